"""One drive of any robot: the truth, what the robot measured of itself, and its failures."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import slerp, transform_from_xyz_quaternion
from navtool.sim.drive.failure import Failure


class Measured(NamedTuple):
    """A stream of a robot's own sensors."""

    time_s: Float64[Array, " k"]
    """When each sample was taken, from the drive's begin; increasing."""
    values: Float64[Array, " k *shape"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """What happened on a drive. World frame with z up, SI units; the body's axes point forward, left and up.

    All arrays of the truth have one entry a step; the steps are regular.
    """

    time_s: Float64[Array, " n"]
    """From the drive's begin, the first entry is 0."""
    position_m: Float64[Array, "n 3"]
    """Positions of base_link."""
    quaternion: Float64[Array, "n 4"]
    """Attitudes of base_link: x, y, z, w."""
    velocity_mps: Float64[Array, "n 3"]
    """Velocities of base_link, in the body's axes."""
    rates_radps: Float64[Array, "n 3"]
    """In the body's axes."""
    command: Float64[Array, "n 2"]
    """Speed in m/s and turn in rad/s that the driver asks for."""
    intervention: Bool[Array, " n"]
    """Whether the operator frees the robot."""
    gait: tuple[tuple[float, str], ...] = ()
    """Gaits of a robot with legs: from when on it goes in which."""

    imu: Measured
    """[k, 6]: specific force in m/s2 (9.81 upwards at rest), turn rates in rad/s; axes of imu_link."""
    joints: Measured
    """[k, 3, J]: position in rad, velocity in rad/s, effort in N m."""
    joint_names: tuple[str, ...]
    odometry: Measured
    """[k, 5]: x, y in metres and yaw in radians since the begin, with drift; forward speed and turn."""
    battery: Measured
    """[k, 2]: current in A, negative while discharging as in ROS, and voltage in V."""

    failures: tuple[Failure, ...]
    """In the order in which they began."""

    @property
    def duration_s(self) -> float:
        """From the first step to the last."""
        return float(self.time_s[-1])

    @property
    def failed_share(self) -> float:
        """Share of the duration during which something had gone wrong, 0-1; failures at once count once."""
        failed = np.zeros(self.time_s.size, bool)
        for failure in self.failures:
            failed |= (self.time_s >= failure.start_s) & (self.time_s < failure.end_s)
        return float(failed.mean())

    def pose(self, time_s: Float64[Array, " m"]) -> Float64[Array, "m 4 4"]:
        """The pose of base_link in the world at times: between steps on the shortest way, beyond the ends as there."""
        step_s = float(self.time_s[1])
        at = np.clip(time_s / step_s, 0.0, self.time_s.size - 1.0)
        low = np.minimum(at.astype(np.int64), self.time_s.size - 2)
        share = at - low
        position = self.position_m[low] + share[:, None] * (self.position_m[low + 1] - self.position_m[low])
        turned = slerp(self.quaternion[low], self.quaternion[low + 1], share)
        return transform_from_xyz_quaternion(position, turned)
