"""Where the sensors sit on the robot and how its camera projects: worked out at ingest, stored, read back."""

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.datasets.decode.messages import Region
from navtool.datasets.robot.camera_fit import fitted
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, TransformTree, camera_from_json
from navtool.datasets.streams.table import POSED, STREAMS, row_of, sensor_of
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.lens_names import lens_of

FOOTPRINT_FRAME = "base_footprint"
"""REP-120: the base frame's projection on the ground."""


class CameraImages(NamedTuple):
    """The pictures that a camera model is wanted for."""

    topic: str
    """One whose name says that it is rectified is projected with P and no distortion."""
    native_size: tuple[int, int] | None
    """Width and height as recorded, in pixels; None where no picture was read."""
    row_size: tuple[int, int]
    """Width and height in the rows, in pixels."""


@dataclass(frozen=True, slots=True)
class SensorGeometry:
    """Geometry of a further camera or LiDAR.

    Attributes:
        pose: Pose of its frame, of a camera the optical one, in the base frame; None where it is unknown.
        camera: The camera at the data set's 320x240 pixels; None where it is unknown, and for a LiDAR.
    """

    pose: Float64[Array, "4 4"] | None
    camera: CameraModel | None = None

    def to_json(self, stream: str) -> dict[str, object]:
        """As plain JSON values, named as those of the first sensor are."""
        pose = {row_of(stream).pose: None if self.pose is None else self.pose.tolist()}
        return pose if row_of(stream).name == "lidar" else {"camera": plain(self.camera)} | pose

    @classmethod
    def from_json(cls, stream: str, content: Mapping[str, Any]) -> "SensorGeometry":
        """What ``to_json`` wrote.

        Raises:
            KeyError, TypeError, ValueError: It is something else.
        """
        camera = content.get("camera")
        return cls(_matrix(content[row_of(stream).pose]), None if camera is None else camera_from_json(camera))


def _matrix(content: Any) -> Float64[Array, "4 4"] | None:
    return None if content is None else np.array(content, dtype=np.float64).reshape(4, 4)


@dataclass(frozen=True, slots=True)
class Calibration:
    """One episode's geometry.

    Attributes:
        camera: The camera at the data set's 320x240 pixels; None where it is unknown.
        base_camera: Pose of the camera's optical frame in the base frame; None where it is unknown.
        base_lidar: Pose of the LiDAR in the base frame; None where it is unknown.
        base_imu: Pose of the IMU in the base frame; None where it is unknown.
        base_odometry: Pose of the odometry's child frame in the base frame; None where it is unknown.
        base_height_m: Height of the base frame's origin above the ground.
        robot_width_m: Width of the swath the robot drives over.
        sources: Where each of these came from, by name, in words.
        recorded: What the recording itself says: frames, static transforms, the camera at its own resolution.
        further: Geometry of further cameras and LiDARs, by their streams: ``camera.rear``.
        notes: What a user should look at where a calibration and its pictures disagree; not written.
    """

    camera: CameraModel | None
    base_camera: Float64[Array, "4 4"] | None
    base_lidar: Float64[Array, "4 4"] | None
    base_imu: Float64[Array, "4 4"] | None
    base_odometry: Float64[Array, "4 4"] | None
    base_height_m: float
    robot_width_m: float
    sources: dict[str, str]
    recorded: RecordedGeometry
    further: Mapping[str, SensorGeometry] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()

    def to_json(self) -> dict[str, object]:
        """The content of ``calibration.json``."""
        poses = {name: getattr(self, name) for name in (STREAMS[stream].pose for stream in POSED)}
        further = {stream: geometry.to_json(stream) for stream, geometry in self.further.items()}
        return {
            "camera": plain(self.camera),
            **{name: None if pose is None else pose.tolist() for name, pose in poses.items()},
            **({"further": further} if further else {}),
            "base_height_m": self.base_height_m,
            "robot_width_m": self.robot_width_m,
            "sources": self.sources,
            "recorded": self.recorded.to_json(),
        }

    def poses(self) -> dict[str, Float64[Array, "4 4"] | None]:
        """The sensors' poses in the base frame, by stream; those of further sensors at the end."""
        first = {stream: getattr(self, STREAMS[stream].pose) for stream in POSED}
        return first | {stream: geometry.pose for stream, geometry in self.further.items()}

    def camera_of(self, stream: str) -> CameraModel | None:
        """The camera of a stream at the data set's 320x240 pixels; None where it is unknown."""
        if not sensor_of(stream):
            return self.camera
        return self.further[stream].camera if stream in self.further else None


def read_calibration(path: Path) -> Calibration:
    """The calibration that ingest wrote.

    Raises:
        DatasetsError: If the file is missing or is not one.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        camera = content["camera"]
        matrices = {name: _matrix(content[name]) for name in (STREAMS[stream].pose for stream in POSED)}
        further = {name: SensorGeometry.from_json(name, x) for name, x in content.get("further", {}).items()}
        poses: dict[str, Any] = dict(matrices)
        return Calibration(
            camera=None if camera is None else camera_from_json(camera),
            **poses,
            base_height_m=float(content["base_height_m"]),
            robot_width_m=float(content["robot_width_m"]),
            sources=dict(content["sources"]),
            recorded=RecordedGeometry.from_json(content["recorded"]),
            further=further,
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DatasetsError(f"is not a calibration ({error})", where=path, cure="ingest the recording again") from error


def calibrate(robot: RobotConfig, recorded: RecordedGeometry, images: Mapping[str, CameraImages]) -> Calibration:
    """Put together what the recording and the robot's configuration say; what neither says stays None.

    Args:
        images: By stream; empty where no camera model is wanted.
    """
    sources: dict[str, str] = {}
    notes: list[Note] = []
    cameras = {stream: _camera(robot, recorded, stream, seen, sources, notes) for stream, seen in images.items()}
    tree = recorded.tree
    further = [stream for stream in recorded.frames if sensor_of(stream) and row_of(stream).pose]
    poses = {stream: _pose(robot, recorded, tree, stream, sources) for stream in (*POSED, *further)}
    footprint = tree.pose(FOOTPRINT_FRAME, robot.base_frame)
    if footprint is not None:
        height, sources["base_height_m"] = float(footprint[2, 3]), f"tf_static: {FOOTPRINT_FRAME} -> {robot.base_frame}"
    else:
        height, sources["base_height_m"] = robot.base_height_m, f"robot {robot.name}: base_height_m"
    return Calibration(
        camera=cameras.get("camera"),
        **{STREAMS[stream].pose: poses[stream] for stream in POSED},
        base_height_m=height,
        robot_width_m=robot.width_m,
        sources=sources,
        recorded=recorded,
        further={stream: SensorGeometry(poses[stream], cameras.get(stream)) for stream in further},
        notes=tuple(notes),
    )


def _named(what: str, stream: str) -> str:
    """A part of the calibration as ``sources`` calls it: ``camera``, ``camera.rear``."""
    sensor = sensor_of(stream)
    return f"{what}.{sensor}" if sensor else what


def _pose(
    robot: RobotConfig, recorded: RecordedGeometry, tree: TransformTree, stream: str, sources: dict[str, str]
) -> Float64[Array, "4 4"] | None:
    name, frame = _named(row_of(stream).pose, stream), recorded.frames.get(stream, "")
    pose = tree.pose(robot.base_frame, frame) if frame else None
    key, mounting = robot.mounting_of(stream)
    if pose is not None and not (mounting is not None and mounting.overrule):
        sources[name] = f"tf_static: {tree.frame(robot.base_frame)} -> {tree.frame(frame)}"
        return pose
    if mounting is None:
        return None
    sources[name] = f"robot {robot.name}: {key}"
    return mounting.pose()


def _camera(
    robot: RobotConfig,
    recorded: RecordedGeometry,
    stream: str,
    images: CameraImages,
    sources: dict[str, str],
    notes: list[Note],
) -> CameraModel | None:
    name, info, region = _named("camera", stream), recorded.info_of(sensor_of(stream)), Region()
    key, fallback = robot.camera_of(stream)
    if info is not None and info.camera.fx > 0 and not (fallback is not None and fallback.overrule):
        model, region = info.camera, info.region
        notes += [Note("camera.lens-name", f"{name}: {info.told}")] if info.told else []
        sources[name] = "the recording's CameraInfo"
        if "rect" in images.topic.removesuffix("/compressed").rsplit("/", 1)[-1]:
            p, matrix = info.projection, "projection matrix"
            if not (p[0, 0] > 0 and p[1, 1] > 0):
                p, matrix = model.matrix(), "intrinsic matrix (it has no projection matrix)"
            model = CameraModel(model.width, model.height, p[0, 0], p[1, 1], p[0, 2], p[1, 2], "none", ())
            sources[name] += f", {matrix} of the rectified image"
    elif fallback is not None:
        lens = lens_of(fallback.distortion_model, tuple(fallback.distortion))
        model = CameraModel(
            fallback.width,
            fallback.height,
            fallback.fx,
            fallback.fy,
            fallback.cx,
            fallback.cy,
            lens.model,
            lens.coefficients,
        )
        sources[name] = f"robot {robot.name}: {key}"
    else:
        return None
    fit = fitted(model, region, images.native_size)
    sources[name] += fit.done
    notes += [note.about(name) for note in fit.notes]
    return fit.camera.scaled_to(*images.row_size)
