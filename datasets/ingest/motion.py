"""How the robot moved, by its odometry, at any moment of a recording."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from navtool.datasets.sync import brackets
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import invert_transform, slerp, transform_from_xyz_quaternion


@dataclass(frozen=True, slots=True)
class Motion:
    """Poses of the base frame in the odometry frame, as odometry gave them.

    Attributes:
        stamps_ns: Strictly increasing times.
        xyz_m: Positions.
        quaternions: Attitudes, (x, y, z, w).
        max_gap_s: Poses further apart than this are not interpolated between.
    """

    stamps_ns: Int64[Array, " n"]
    xyz_m: Float64[Array, "n 3"]
    quaternions: Float64[Array, "n 4"]
    max_gap_s: float

    def between(self, start_ns: int, end_ns: int) -> "Motion":
        """The poses from one moment to another, and one beyond either end."""
        first = max(int(np.searchsorted(self.stamps_ns, start_ns)) - 1, 0)
        last = int(np.searchsorted(self.stamps_ns, end_ns, side="right")) + 1
        rows = slice(first, last)
        return Motion(self.stamps_ns[rows], self.xyz_m[rows], self.quaternions[rows], self.max_gap_s)

    def relative_to(self, moment_ns: int, times_ns: Int64[Array, " k"]) -> Float64[Array, "k 4 4"] | None:
        """Poses of the base frame at some times in the base frame at a moment; None where odometry does not say."""
        asked = np.concatenate([[moment_ns], times_ns])
        around = brackets(self.stamps_ns, asked, self.max_gap_s)
        if not around.valid.all():
            return None
        xyz = around.linear(self.xyz_m)
        attitude = slerp(self.quaternions[around.before], self.quaternions[around.after], around.weight)
        if not (np.isfinite(xyz).all() and np.isfinite(attitude).all()):
            return None
        poses = transform_from_xyz_quaternion(xyz, attitude)
        relative: Array = invert_transform(poses[0]) @ poses[1:]
        return relative
