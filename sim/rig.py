"""Where the demo robot carries its sensors, and its camera's calibration."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy

type Pose = tuple[float, float, float, float, float, float]
"""x, y, z in metres and roll, pitch, yaw in radians."""

MOUNTS: dict[tuple[str, str], Pose] = {
    ("base_footprint", "base_link"): (0.0, 0.0, 0.15, 0.0, 0.0, 0.0),
    ("base_link", "camera_link"): (0.28, 0.0, 0.40, 0.0, 0.10, 0.0),
    ("camera_link", "camera_front_optical"): (0.0, 0.0, 0.0, -np.pi / 2, 0.0, -np.pi / 2),
    ("base_link", "velodyne"): (0.05, 0.0, 0.58, 0.0, 0.0, 0.0),
    ("base_link", "imu_link"): (0.0, 0.0, 0.10, 0.0, 0.0, 0.0),
}
"""Pose of each child frame in its parent: (parent, child) to x, y, z, roll, pitch, yaw. REP-103 and REP-105."""

WHEEL_RADIUS_M = 0.165
TRACK_WIDTH_M = 0.55
WHEELS = ("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel")


@dataclass(kw_only=True, slots=True)
class RigConfig:
    """The camera's size and the rates of the sensors."""

    width: int = 320
    """Width of the camera image in pixels, at least 32; the height is three quarters of it."""
    camera_hz: float = 15.0
    """Camera frames a second, in (0, 60]."""
    jpeg_quality: int = 85
    """JPEG quality of the recorded frames, 1-100."""
    drop_share: float = 0.01
    """Share of the camera frames and clouds that never reach the recording, in [0, 0.5]."""

    def __post_init__(self) -> None:
        if self.width < 32 or not 0 < self.camera_hz <= 60:
            raise ValueError(f"need width >= 32 px and 0 < camera_hz <= 60, got {self.width} px, {self.camera_hz} Hz")
        if not 1 <= self.jpeg_quality <= 100 or not 0 <= self.drop_share <= 0.5:
            what = f"need jpeg_quality in 1-100 and drop_share in 0-0.5, got {self.jpeg_quality}, {self.drop_share}"
            raise ValueError(what)


def camera_model(width: int) -> CameraModel:
    """Return the calibration of the front camera for an image width: 70 degrees wide, without distortion."""
    height = round(0.75 * width)
    focal = width / 2 / float(np.tan(np.radians(35.0)))
    centre = (width - 1) / 2, (height - 1) / 2
    return CameraModel(
        width=width,
        height=height,
        fx=focal,
        fy=focal,
        cx=centre[0],
        cy=centre[1],
        distortion_model="plumb_bob",
        distortion=(0.0, 0.0, 0.0, 0.0, 0.0),
    )


def mount(child: str) -> Float[Array, "4 4"]:
    """Return the pose of a frame of ``MOUNTS`` in base_footprint."""
    pose = np.eye(4)
    while child != "base_footprint":
        parent = next(parent for parent, name in MOUNTS if name == child)
        values = np.array(MOUNTS[(parent, child)])
        pose = transform_from_xyz_rpy(values[:3], values[3:]) @ pose
        child = parent
    return pose
