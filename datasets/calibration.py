"""Where the sensors sit on the robot and how its camera projects: worked out at ingest, stored, read back."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from navtool.datasets.decode.messages import CameraInfoSample, Transform
from navtool.datasets.errors import DatasetsError
from navtool.datasets.robot import RobotConfig
from navtool.datasets.schema import IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import invert_transform, transform_from_xyz_rpy

FOOTPRINT_FRAME = "base_footprint"
"""REP-120: the base frame's projection on the ground."""


@dataclass(frozen=True, slots=True)
class Calibration:
    """One episode's geometry.

    Attributes:
        camera: The camera at the data set's 320x240 pixels; None where it is unknown.
        base_camera: Pose of the camera's optical frame in the base frame; None where it is unknown.
        base_lidar: Pose of the LiDAR in the base frame; None where it is unknown.
        base_imu: Pose of the IMU in the base frame; None where it is unknown.
        base_height_m: Height of the base frame's origin above the ground.
        robot_width_m: Width of the swath the robot drives over.
        sources: Where each of these came from, by name, in words.
    """

    camera: CameraModel | None
    base_camera: Float64[Array, "4 4"] | None
    base_lidar: Float64[Array, "4 4"] | None
    base_imu: Float64[Array, "4 4"] | None
    base_height_m: float
    robot_width_m: float
    sources: dict[str, str]

    def to_json(self) -> dict[str, object]:
        """The content of ``calibration.json``."""
        camera = self.camera
        return {
            "camera": None
            if camera is None
            else {
                "width": camera.width,
                "height": camera.height,
                "fx": camera.fx,
                "fy": camera.fy,
                "cx": camera.cx,
                "cy": camera.cy,
                "distortion_model": camera.distortion_model,
                "distortion": list(camera.distortion),
            },
            **{
                name: None if matrix is None else matrix.tolist()
                for name, matrix in (
                    ("base_camera", self.base_camera),
                    ("base_lidar", self.base_lidar),
                    ("base_imu", self.base_imu),
                )
            },
            "base_height_m": self.base_height_m,
            "robot_width_m": self.robot_width_m,
            "sources": self.sources,
        }


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
            for name in ("base_camera", "base_lidar", "base_imu")
        }
        return Calibration(
            camera=None if camera is None else CameraModel(**camera | {"distortion": tuple(camera["distortion"])}),
            **matrices,
            base_height_m=float(content["base_height_m"]),
            robot_width_m=float(content["robot_width_m"]),
            sources=dict(content["sources"]),
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DatasetsError(f"is not a calibration ({error})", where=path, cure="ingest the recording again") from error


def calibrate(
    robot: RobotConfig,
    transforms: Sequence[Transform],
    camera_info: CameraInfoSample | None,
    *,
    image_topic: str | None,
    native_size: tuple[int, int] | None,
    frames: dict[str, str],
) -> Calibration:
    """Put together what the recording and the robot's configuration say; what neither says stays None.

    Args:
        transforms: The recording's static transforms.
        camera_info: The front camera's, where there is one.
        image_topic: An image whose name says it is rectified is projected with P and no distortion.
        native_size: Width and height of the recorded frames in pixels.
        frames: Frame of each sensor (``image``, ``lidar``, ``imu``) as the messages name it; may be empty.
    """
    sources: dict[str, str] = {}
    camera = _camera(robot, camera_info, image_topic, native_size, sources)
    tree = TransformTree(transforms)
    poses: dict[str, Float64[Array, "4 4"] | None] = {}
    for sensor in ("image", "lidar", "imu"):
        frame = frames.get(sensor, "")
        pose = tree.pose(robot.base_frame, frame) if frame else None
        if pose is not None:
            sources[f"base_{sensor}"] = f"tf_static: {robot.base_frame} -> {frame}"
        elif sensor in robot.mounting:
            mounting = robot.mounting[sensor]
            pose = transform_from_xyz_rpy(np.array(mounting.xyz_m), np.array(mounting.rpy_rad))
            sources[f"base_{sensor}"] = f"robot {robot.name}: mounting.{sensor}"
        poses[sensor] = pose
    footprint = tree.pose(FOOTPRINT_FRAME, robot.base_frame)
    if footprint is not None:
        height, sources["base_height_m"] = float(footprint[2, 3]), f"tf_static: {FOOTPRINT_FRAME} -> {robot.base_frame}"
    else:
        height, sources["base_height_m"] = robot.base_height_m, f"robot {robot.name}: base_height_m"
    return Calibration(camera, poses["image"], poses["lidar"], poses["imu"], height, robot.width_m, sources)


class TransformTree:
    """Static transforms as a graph: the pose of any frame in any other that it is connected with."""

    def __init__(self, transforms: Sequence[Transform]) -> None:
        self._edges: dict[str, dict[str, Float64[Array, "4 4"]]] = {}
        for transform in transforms:
            parent, child = transform.parent.lstrip("/"), transform.child.lstrip("/")
            self._edges.setdefault(parent, {})[child] = transform.matrix
            self._edges.setdefault(child, {})[parent] = invert_transform(transform.matrix)

    def pose(self, target: str, source: str) -> Float64[Array, "4 4"] | None:
        """The pose of ``source`` in ``target`` (p_target = pose @ p_source); None where no path joins them."""
        start, goal = target.lstrip("/"), source.lstrip("/")
        if start == goal:
            return np.eye(4)
        reached = {start: np.eye(4)}
        border = [start]
        while border:
            frame = border.pop()
            for neighbour, matrix in self._edges.get(frame, {}).items():
                if neighbour not in reached:
                    reached[neighbour] = reached[frame] @ matrix
                    border.append(neighbour)
        return reached.get(goal)


def _camera(
    robot: RobotConfig,
    info: CameraInfoSample | None,
    image_topic: str | None,
    native_size: tuple[int, int] | None,
    sources: dict[str, str],
) -> CameraModel | None:
    if image_topic is None:
        return None
    if info is not None and info.camera.fx > 0:
        model = info.camera
        sources["camera"] = "the recording's CameraInfo"
        if "rect" in image_topic.removesuffix("/compressed").rsplit("/", 1)[-1]:
            p = info.projection
            model = CameraModel(model.width, model.height, p[0, 0], p[1, 1], p[0, 2], p[1, 2], "none", ())
            sources["camera"] += ", projection matrix of the rectified image"
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
    if native_size is not None and native_size != (model.width, model.height):
        calibrated, recorded = f"{model.width}x{model.height}", f"{native_size[0]}x{native_size[1]}"
        sources["camera"] += f", calibrated at {calibrated}, recorded at {recorded}"
    return model.scaled_to(IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX)
