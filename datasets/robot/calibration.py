"""Where the sensors sit on the robot and how its camera projects: worked out at ingest, stored, read back."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.base.plain import plain
from navtool.datasets.decode.messages import CameraInfoSample
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, camera_from_json
from navtool.datasets.streams.table import POSED, STREAMS
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy

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

    def to_json(self) -> dict[str, object]:
        """The content of ``calibration.json``."""
        poses = {STREAMS[stream].pose: None if pose is None else pose.tolist() for stream, pose in self.poses().items()}
        return {
            "camera": plain(self.camera),
            **poses,
            "base_height_m": self.base_height_m,
            "robot_width_m": self.robot_width_m,
            "sources": self.sources,
            "recorded": self.recorded.to_json(),
        }

    def poses(self) -> dict[str, Float64[Array, "4 4"] | None]:
        """The sensors' poses in the base frame, by stream."""
        return {stream: getattr(self, STREAMS[stream].pose) for stream in POSED}


def read_calibration(path: Path) -> Calibration:
    """The calibration that ingest wrote.

    Raises:
        DatasetsError: If the file is missing or is not one.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        camera = content["camera"]
        matrices = {
            name: None if content[name] is None else np.array(content[name], dtype=np.float64).reshape(4, 4)
            for name in (STREAMS[stream].pose for stream in POSED)
        }
        return Calibration(
            camera=None if camera is None else camera_from_json(camera),
            **matrices,
            base_height_m=float(content["base_height_m"]),
            robot_width_m=float(content["robot_width_m"]),
            sources=dict(content["sources"]),
            recorded=RecordedGeometry.from_json(content["recorded"]),
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DatasetsError(f"is not a calibration ({error})", where=path, cure="ingest the recording again") from error


def calibrate(robot: RobotConfig, recorded: RecordedGeometry, images: CameraImages | None) -> Calibration:
    """Put together what the recording and the robot's configuration say; what neither says stays None.

    Args:
        images: None where no camera model is wanted.
    """
    sources: dict[str, str] = {}
    camera = None if images is None else _camera(robot, recorded.camera_info, images, sources)
    tree = recorded.tree
    poses: dict[str, Float64[Array, "4 4"] | None] = {}
    for sensor in POSED:
        name = STREAMS[sensor].pose
        frame = recorded.frames.get(sensor, "")
        pose = tree.pose(robot.base_frame, frame) if frame else None
        if pose is not None:
            sources[name] = f"tf_static: {tree.frame(robot.base_frame)} -> {tree.frame(frame)}"
        elif sensor in robot.mounting:
            mounting = robot.mounting[sensor]
            pose = transform_from_xyz_rpy(np.array(mounting.xyz_m), np.array(mounting.rpy_rad))
            sources[name] = f"robot {robot.name}: mounting.{sensor}"
        poses[name] = pose
    footprint = tree.pose(FOOTPRINT_FRAME, robot.base_frame)
    if footprint is not None:
        height, sources["base_height_m"] = float(footprint[2, 3]), f"tf_static: {FOOTPRINT_FRAME} -> {robot.base_frame}"
    else:
        height, sources["base_height_m"] = robot.base_height_m, f"robot {robot.name}: base_height_m"
    return Calibration(
        camera=camera, **poses, base_height_m=height, robot_width_m=robot.width_m, sources=sources, recorded=recorded
    )


def _camera(
    robot: RobotConfig, info: CameraInfoSample | None, images: CameraImages, sources: dict[str, str]
) -> CameraModel | None:
    if info is not None and info.camera.fx > 0:
        model = info.camera
        sources["camera"] = "the recording's CameraInfo"
        if "rect" in images.topic.removesuffix("/compressed").rsplit("/", 1)[-1]:
            p, name = info.projection, "projection matrix"
            if not (p[0, 0] > 0 and p[1, 1] > 0):
                p, name = model.matrix(), "intrinsic matrix (it has no projection matrix)"
            model = CameraModel(model.width, model.height, p[0, 0], p[1, 1], p[0, 2], p[1, 2], "none", ())
            sources["camera"] += f", {name} of the rectified image"
    elif robot.camera is not None:
        fallback = robot.camera
        model = CameraModel(
            fallback.width,
            fallback.height,
            fallback.fx,
            fallback.fy,
            fallback.cx,
            fallback.cy,
            fallback.distortion_model,
            tuple(fallback.distortion),
        )
        sources["camera"] = f"robot {robot.name}: camera"
    else:
        return None
    if images.native_size is not None and images.native_size != (model.width, model.height):
        calibrated, recorded = f"{model.width}x{model.height}", f"{images.native_size[0]}x{images.native_size[1]}"
        sources["camera"] += f", calibrated at {calibrated}, recorded at {recorded}"
    return model.scaled_to(*images.row_size)
