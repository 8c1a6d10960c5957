"""What is fixed about a robot: its topics, frames, joints, mounting and size."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import numpy as np
import yaml
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.base.from_plain import did_you_mean, from_plain
from navtool.base.plain import LEFT_OUT_WHILE_EMPTY, plain
from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, refuse
from navtool.base.yaml_text import load_yaml
from navtool.datasets.decode.levels import Levels
from navtool.datasets.decode.picture_view import Colours, PictureView
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.streams.table import FRONT, POSED, SENSOR_NAME, STREAMS, further, in_order, row_of, sensor_of
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.distortion import LENS_MODELS
from navtool.pipeline.geometry.lens_names import lens_of
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy

_MOST_SAMPLE = 65_535
NO_TOPIC = "none"
"""As the only candidate of a stream: the robot's recordings have this topic, but it is not wanted."""


@dataclass(kw_only=True, slots=True)
class TopicCandidates:
    """Topic names per stream, best first; the first one that the recording has with messages is taken.

    They are of the first camera and LiDAR; further ones stand under ``cameras`` and ``lidars``.

    A name with a leading slash is matched whole; ``platform/odom`` without one matches in any namespace.
    An empty list means that a topic is proposed from the types and names; ``[none]`` leaves the stream out.
    """

    camera: list[str] = field(default_factory=list)
    """Image or CompressedImage of the front camera."""
    camera_info: list[str] = field(default_factory=list)
    """CameraInfo of that camera; proposed: the one in the image's namespace."""
    lidar: list[str] = field(default_factory=list)
    """PointCloud2 of the LiDAR, unfiltered and in the sensor's frame; VLP-16 packets, Livox's CustomMsg, LaserScan; if
    named, the old PointCloud."""
    odometry: list[str] = field(default_factory=list)
    """Odometry in a smooth local frame; if named, a PoseStamped, whose differences then give the speeds."""
    imu: list[str] = field(default_factory=list)
    """Imu at its native rate."""
    joints: list[str] = field(default_factory=list)
    """JointState."""
    battery: list[str] = field(default_factory=list)
    """BatteryState, or if named a vendor's state or a Float32 or Float64 with the current in A."""
    command: list[str] = field(default_factory=list)
    """Twist or TwistStamped, or if named Odometry or Joy: the velocity asked of the robot."""
    intervention: list[str] = field(default_factory=list)
    """std_msgs Bool: true while an operator overrides the robot; or if named a vendor's state with a stop or pedals."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            names: list[str] = getattr(self, entry.name)
            mixed = NO_TOPIC in names and len(names) > 1
            alone = f"write [{NO_TOPIC}] alone to leave the stream out, or remove it"
            refuse(
                _empty_name(entry.name, names),
                fault(entry.name, f"'{NO_TOPIC}' stands beside topics in {names}", alone, when=mixed),
            )


def _empty_name(key: str, names: list[str]) -> list[Fault]:
    empty = any(not name.strip("/ ") for name in names)
    return fault(key, f"an empty topic name in {names}", "remove it, or name a topic", when=empty)


@dataclass(kw_only=True, slots=True)
class CameraFallback:
    """Calibration of a camera, for recordings that have no CameraInfo of it."""

    width: int
    """Width of the calibrated image in pixels."""
    height: int
    """Height of the calibrated image in pixels."""
    fx: float
    """Focal length along columns in pixels."""
    fy: float
    """Focal length along rows in pixels."""
    cx: float
    """Principal point's column in pixels."""
    cy: float
    """Principal point's row in pixels."""
    distortion_model: str = "none"
    """none, plumb_bob, rational_polynomial or equidistant, or as a driver spells them."""
    distortion: list[float] = field(default_factory=list)
    """Coefficients in OpenCV's order; plumb_bob and rational_polynomial 4 to 14, equidistant 4."""
    overrule: bool = field(default=False, metadata=LEFT_OUT_WHILE_EMPTY)
    """Whether it counts although the recording has a CameraInfo, which is wrong."""

    def __post_init__(self) -> None:
        pixels = ("width", "height", "fx", "fy")
        calibrated = "give it in pixels of the calibrated image"
        refuse(
            outside(self, 0, math.inf, *pixels, unit="px", above=True, below=True, cure=calibrated),
            _lens_fault(self.distortion_model, self.distortion),
        )


def _lens_fault(model: str, coefficients: list[float]) -> list[Fault]:
    """What is wrong with a lens as a robot file describes it."""
    if not all(map(math.isfinite, coefficients)):
        return [Fault("distortion", f"{coefficients} are not finite numbers", "give the lens's coefficients")]
    try:
        told = lens_of(model, tuple(coefficients)).told
    except ValueError as error:
        if "coefficients; expected" in str(error):
            return [Fault("distortion", f"{coefficients}: {error}", "give as many as the model has")]
        known = ", ".join(LENS_MODELS)
        return [Fault("distortion_model", f"there is no distortion model {model!r}", f"use one of {known}")]
    return [Fault("distortion", f"{coefficients}: {told}", "name the lens model of these coefficients")] if told else []


@dataclass(kw_only=True, slots=True)
class Mounting:
    """Pose of a sensor's frame in the base frame, for recordings whose tf has no path between them."""

    xyz_m: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Position in the base frame: forward, left, up."""
    rpy_rad: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Roll, pitch, yaw about the base's fixed axes; of the optical frame (z forward, x right) for the camera."""
    overrule: bool = field(default=False, metadata=LEFT_OUT_WHILE_EMPTY)
    """Whether it counts although the recording's tf has a pose, which is wrong."""

    def __post_init__(self) -> None:
        for name, unit in (("xyz_m", "metres"), ("rpy_rad", "radians")):
            values: list[float] = getattr(self, name)
            three = len(values) == 3 and all(map(math.isfinite, values))
            refuse(
                fault(name, f"{values} are not three finite numbers", f"give three numbers in {unit}", when=not three)
            )
        turned = any(abs(value) > 2 * math.pi for value in self.rpy_rad)
        refuse(
            fault("rpy_rad", f"{self.rpy_rad} rad is more than a full turn", "give radians, not degrees", when=turned),
        )

    def pose(self) -> Float64[Array, "4 4"]:
        """As a matrix: p_base = M p_sensor."""
        return transform_from_xyz_rpy(np.array(self.xyz_m), np.array(self.rpy_rad))


@dataclass(kw_only=True, slots=True)
class PictureSettings:
    """How a camera's pictures are shown, where a recording's own first seconds and its formats are not to say it."""

    range: list[int] = field(default_factory=list)
    """Samples of 16-bit pictures that become black and white, 0 to 65535; empty goes by a recording's first seconds."""
    colours: Colours = Colours.auto
    """auto goes by encodings and formats; as_held takes compressed pictures as the files have them; exchanged exchanges
    red and blue."""

    def __post_init__(self) -> None:
        two = len(self.range) == 2 and 0 <= self.range[0] < self.range[1] <= _MOST_SAMPLE
        what = f"{self.range} are not two numbers of 0 to {_MOST_SAMPLE}, the smaller one in front"
        refuse(fault("range", what, "give black and white", when=bool(self.range) and not two))

    def view(self, levels: Levels) -> PictureView:
        """How pictures are shown that would be shown at these levels."""
        return PictureView(Levels(*self.range) if self.range else levels, self.colours)


@dataclass(kw_only=True, slots=True)
class FurtherSensor:
    """A sensor beside the first one of its kind."""

    topics: list[str]
    """Candidate topics, best first; it is never proposed."""
    mounting: Mounting | None = None
    """Pose where tf has no path to the base frame."""
    frame: str = field(default="", metadata=LEFT_OUT_WHILE_EMPTY)
    """Its frame, where several sensors publish on its topic; empty takes the one with most messages."""

    def __post_init__(self) -> None:
        without = not self.topics or NO_TOPIC in self.topics
        refuse(
            fault("topics", f"{self.topics} names no topic", "name its topic, or remove the sensor", when=without),
            _empty_name("topics", self.topics),
        )


@dataclass(kw_only=True, slots=True)
class FurtherCamera(FurtherSensor):
    """A camera beside the front camera."""

    camera_info: list[str] = field(default_factory=list)
    """Candidate topics of its CameraInfo; empty takes the one in its images' namespace."""
    calibration: CameraFallback | None = None
    """Calibration where a recording has none of this camera."""


@dataclass(kw_only=True, slots=True)
class FurtherLidar(FurtherSensor):
    """A LiDAR beside the first one; its clouds are kept whole, beside the rows."""


@dataclass(kw_only=True, slots=True)
class JoyCommand:
    """How a joystick (sensor_msgs/Joy) asks for a velocity, where the recording has no commands but its axes."""

    forward_axis: int
    """Axis of the forward speed, from 0."""
    forward_mps: float
    """Speed that the axis asks for at +1; negative where forward is -1."""
    turn_axis: int
    """Axis of the turning rate, from 0."""
    turn_radps: float
    """Rate to the left that the axis asks for at +1; negative where left is -1."""
    left_axis: int = -1
    """Axis of the speed to the left; -1 for none."""
    left_mps: float = 0.0
    """Speed to the left that the axis asks for at +1."""
    dead_zone: float = 0.02
    """Deflection below which an axis counts as released, in [0, 1)."""
    enable_button: int = -1
    """Button without which the robot stands; -1 for none."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 63, "forward_axis", "turn_axis", cure="count the axes from 0"),
            outside(self, 0, 1, "dead_zone", below=True, cure="give a share"),
            outside(self, -50, 50, "forward_mps", "left_mps", unit="m/s"),
            outside(self, -50, 50, "turn_radps", unit="rad/s"),
        )


@dataclass(kw_only=True, slots=True)
class InterventionFlag:
    """What the intervention's flag means."""

    inverted: bool | None = None
    """Whether true means that all is well; None leaves it to its name and to what the robot does meanwhile."""


@dataclass(kw_only=True, slots=True)
class RobotConfig:
    """One robot as its recordings see it; every stream that is left open is proposed from each recording."""

    name: str = "robot"
    """Written into the data set as its robot type."""
    task: str = "navigate"
    """What the robot does in these recordings, in a few words."""
    topics: TopicCandidates = field(default_factory=TopicCandidates)
    """Candidate topics per stream."""
    base_frame: str = "base_link"
    """The tf frame whose axes the data set uses: x forward, y left, z up."""
    base_height_m: float = 0.0
    """Height of the base frame's origin above the ground, in [0, 5]."""
    joint_names: list[str] = field(default_factory=list)
    """Joints in the data set's order; empty takes the first message's order."""
    width_m: float = 0.5
    """Width of the swath that the robot drives over, in (0, 5]."""
    battery_current_sign: int = -1
    """Sign that a discharging current has in the recordings; sensor_msgs says negative. The data set's is positive.

    0 where it is not known: then each recording's median current is taken for a discharge, and a note says so.
    """
    odometry_yaw_rad: float = 0.0
    """Added to the yaw of the odometry's poses, in the body's own frame; where x of its body does not look forward."""
    odometry_twist: OdometryTwist | None = field(default=None, metadata=LEFT_OUT_WHILE_EMPTY)
    """Where the odometry's speeds come from: as_recorded, parent_frame (turned out of the axes of its poses' frame) or
    from_poses; None compares them with the poses, mends what these tell, and says so."""
    intervention: InterventionFlag = field(default_factory=InterventionFlag)
    """What the flag of the stream ``intervention`` means."""
    joy: JoyCommand | None = None
    """What the axes of a joystick mean that stands in for commands; None where there is none."""
    camera: CameraFallback | None = None
    """Calibration where a recording has none; None leaves such recordings without one."""
    mounting: dict[str, Mounting] = field(default_factory=dict)
    """Poses by ``camera``, ``lidar``, ``imu`` or ``odometry`` (its child) where tf has no path to the base frame."""
    frames: dict[str, str] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    """Frames by ``camera``, ``lidar``, ``imu`` or ``odometry`` (its child): which of several sensors on one topic."""
    cameras: dict[str, FurtherCamera] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    """Further cameras by name, such as ``rear``."""
    lidars: dict[str, FurtherLidar] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    """Further LiDARs by name."""
    pictures: dict[str, PictureSettings] = field(default_factory=dict, metadata=LEFT_OUT_WHILE_EMPTY)
    """How pictures are shown, by camera: ``front`` for the first one, further ones by their names."""

    def __post_init__(self) -> None:
        signs = (
            "give 1 where a discharging current is positive in the recordings, -1 where it is negative, 0 where that "
            "is not known"
        )
        joints = sorted({joint for joint in self.joint_names if self.joint_names.count(joint) > 1})
        sensors = [name + did_you_mean(name, POSED) for name in sorted(set(self.mounting) - set(POSED))]
        framed = [name + did_you_mean(name, POSED) for name in sorted(set(self.frames) - set(POSED))]
        refuse(
            fault("name", "the robot has no name", "give one, such as husky", when=not self.name.strip()),
            fault("base_frame", "is empty", "give a tf frame, such as base_link", when=not self.base_frame.strip()),
            outside(self, 0, 5, "base_height_m", unit="m", cure="give the base frame's height above the ground"),
            outside(self, 0, 5, "width_m", unit="m", above=True, cure="give the robot's width in metres"),
            fault(
                "battery_current_sign",
                f"{self.battery_current_sign} is none of -1, 0 and 1",
                signs,
                when=self.battery_current_sign not in (-1, 0, 1),
            ),
            fault(
                "odometry_yaw_rad",
                f"{self.odometry_yaw_rad} rad is more than half a turn",
                "give radians in [-pi, pi], not degrees",
                when=not abs(self.odometry_yaw_rad) <= math.pi,
            ),
            fault("joint_names", f"{', '.join(joints)} named twice", "name every joint once", when=bool(joints)),
            fault(
                "mounting", f"unknown sensors {', '.join(sensors)}", f"known are {', '.join(POSED)}", when=bool(sensors)
            ),
            fault("frames", f"unknown sensors {', '.join(framed)}", f"known are {', '.join(POSED)}", when=bool(framed)),
            _unknown_cameras(self.pictures, (FRONT, *self.cameras)),
            _unfit_names("cameras", self.cameras),
            _unfit_names("lidars", self.lidars),
        )

    def candidates(self) -> dict[str, list[str]]:
        """Candidate topics by stream, in the order of the stream table, a further sensor's behind the first one's."""
        topics: dict[str, list[str]] = {stream: getattr(self.topics, stream) for stream in STREAMS}
        for name, camera in self.cameras.items():
            topics[further("camera", name)] = camera.topics
            topics[further("camera_info", name)] = camera.camera_info
        topics |= {further("lidar", name): lidar.topics for name, lidar in self.lidars.items()}
        return {stream: topics[stream] for stream in in_order(topics)}

    def source_frames(self) -> dict[str, str]:
        """The frame that is wanted of a stream's topic, by stream, where it is said."""
        further_ones = {further("camera", name): camera.frame for name, camera in self.cameras.items()}
        further_ones |= {further("lidar", name): lidar.frame for name, lidar in self.lidars.items()}
        return self.frames | {stream: frame for stream, frame in further_ones.items() if frame}

    def mounting_of(self, stream: str) -> tuple[str, Mounting | None]:
        """Where the pose of a stream's sensor stands in the robot file, and the pose; None where it stands nowhere."""
        sensor = sensor_of(stream)
        if not sensor:
            return f"mounting.{stream}", self.mounting.get(stream)
        group = "cameras" if row_of(stream).name == "camera" else "lidars"
        sensors: dict[str, FurtherCamera] | dict[str, FurtherLidar] = getattr(self, group)
        return f"{group}.{sensor}.mounting", sensors[sensor].mounting if sensor in sensors else None

    def view_of(self, stream: str, levels: Levels) -> PictureView:
        """How the pictures of a camera's stream are shown that would be shown at these levels."""
        return self.pictures.get(sensor_of(stream) or FRONT, PictureSettings()).view(levels)

    def camera_of(self, stream: str) -> tuple[str, CameraFallback | None]:
        """Where the calibration of a camera's stream stands in the robot file, and the calibration."""
        sensor = sensor_of(stream)
        if not sensor:
            return "camera", self.camera
        return f"cameras.{sensor}.calibration", self.cameras[sensor].calibration if sensor in self.cameras else None


def _unknown_cameras(pictures: Iterable[str], cameras: Sequence[str]) -> list[Fault]:
    """Cameras that the robot does not have, whose pictures are to be shown in some way."""
    unknown = [name + did_you_mean(name, cameras) for name in pictures if name not in cameras]
    what, known = f"unknown cameras {', '.join(unknown)}", f"known are {', '.join(cameras)}"
    return fault("pictures", what, known, when=bool(unknown))


def _unfit_names(group: str, names: Iterable[str]) -> list[Fault]:
    """The names that further sensors cannot have."""
    cure = "use small letters, digits and _, a letter first; the first camera alone is 'front'"
    unfit = [name for name in names if not SENSOR_NAME.fullmatch(name) or (group, name) == ("cameras", FRONT)]
    return [Fault(group, f"a sensor cannot be called {name!r}", cure) for name in unfit]


def load_robot_file(path: Path) -> RobotConfig:
    """The robot described by a YAML file, as ``save_robot_file`` writes it.

    Raises:
        DatasetsError: If the file cannot be read, or is not YAML.
        SettingError: If it has unknown keys or wrong values; all are named.
    """
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DatasetsError(
            f"cannot be read ({error.strerror})", where=path, cure="check the path of the robot file"
        ) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        first = " ".join(str(error).split())
        raise DatasetsError(f"is not YAML: {first}", where=path, cure="correct the file's syntax") from error
    return from_plain(RobotConfig, content, where=path)


def save_robot_file(robot: RobotConfig, path: Path) -> None:
    """Write the robot as YAML that ``load_robot_file`` reads back equal; an existing file is replaced.

    Raises:
        DatasetsError: If the file cannot be written.
    """
    text = yaml.safe_dump(plain(robot), sort_keys=False, allow_unicode=True, default_flow_style=None, width=120)
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise DatasetsError(
            f"cannot be written ({error.strerror})", where=path, cure="choose a folder that can be written"
        ) from error
