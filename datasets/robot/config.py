"""What is fixed about a robot: its topics, frames, joints, mounting and size."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path

import yaml

from navtool.base.errors import DatasetsError
from navtool.base.from_plain import did_you_mean, from_plain
from navtool.base.plain import LEFT_OUT_WHILE_EMPTY, plain
from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, refuse
from navtool.base.yaml_text import load_yaml
from navtool.datasets.decode.levels import Levels
from navtool.datasets.decode.picture_view import PictureView
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.robot.sensor_config import (
    NO_TOPIC,
    CameraFallback,
    FurtherCamera,
    FurtherLidar,
    Mounting,
    PictureSettings,
    empty_name,
)
from navtool.datasets.streams.table import FRONT, POSED, SENSOR_NAME, STREAMS, further, in_order, row_of, sensor_of


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
                empty_name(entry.name, names),
                fault(entry.name, f"'{NO_TOPIC}' stands beside topics in {names}", alone, when=mixed),
            )


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
