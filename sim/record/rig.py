"""Where each robot carries its sensors: frames of REP-103 and REP-105."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy

type Pose = tuple[float, float, float, float, float, float]
"""x, y, z in metres and roll, pitch, yaw in radians."""

BASE, CAMERA, LIDAR, IMU = "base_link", "camera_front_optical", "velodyne", "imu_link"
"""Frames that messages name in their headers."""
MAP, ODOM = "map", "odom"
_OPTICAL: Pose = (0.0, 0.0, 0.0, -np.pi / 2, 0.0, -np.pi / 2)


class RobotKind(StrEnum):
    """Which robot drives."""

    wheeled = "wheeled"
    """Four wheels, skid-steered; quick to simulate."""
    quadruped = "quadruped"
    """Twelve joints in MuJoCo."""


@dataclass(frozen=True, slots=True)
class Rig:
    """The fixed frames of one robot."""

    mounts: dict[tuple[str, str], Pose]
    """Pose of each child frame in its parent: (parent, child). All hang from base_link."""

    def mount(self, frame: str) -> Float64[Array, "4 4"]:
        """The pose of a frame in base_link."""
        pose = np.eye(4)
        while frame != BASE:
            parent = next(parent for parent, child in self.mounts if child == frame)
            values = np.array(self.mounts[(parent, frame)])
            pose = transform_from_xyz_rpy(values[:3], values[3:]) @ pose
            frame = parent
        return pose


RIGS = {
    RobotKind.wheeled: Rig(
        {
            (BASE, "base_footprint"): (0.0, 0.0, -0.165, 0.0, 0.0, 0.0),
            (BASE, "camera_link"): (0.40, 0.0, 0.40, 0.0, 0.35, 0.0),
            ("camera_link", CAMERA): _OPTICAL,
            (BASE, LIDAR): (0.05, 0.0, 0.58, 0.0, 0.0, 0.0),
            (BASE, IMU): (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        }
    ),
    RobotKind.quadruped: Rig(
        {
            (BASE, "base_footprint"): (0.0, 0.0, -0.48, 0.0, 0.0, 0.0),
            (BASE, "camera_link"): (0.42, 0.0, 0.10, 0.0, 0.35, 0.0),
            ("camera_link", CAMERA): _OPTICAL,
            (BASE, LIDAR): (0.05, 0.0, 0.26, 0.0, 0.0, 0.0),
            (BASE, IMU): (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        }
    ),
}
"""base_link hangs from odom, as REP-105 has it, and base_footprint from base_link: on a quadruped, whose body rises and
sinks as it walks, it is where the ground is while it stands."""
