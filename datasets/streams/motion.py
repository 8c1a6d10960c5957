"""How the robot moved, by its odometry, at any moment of a recording."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Float64, Int64

from navtool.datasets.streams.sync import brackets
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.deskew import deskewed
from navtool.pipeline.geometry.transforms import invert_transform, slerp, transform_from_xyz_quaternion

_KNOTS = 17
"""Moments of a sweep for which the robot's pose is taken from odometry."""


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

    def pose(self, moment_ns: int) -> Float64[Array, "4 4"] | None:
        """The pose of the base frame at a moment; None where odometry does not say."""
        poses = self._poses(np.array([moment_ns], dtype=np.int64))
        return None if poses is None else poses[0]

    def relative_to(self, moment_ns: int, times_ns: Int64[Array, " k"]) -> Float64[Array, "k 4 4"] | None:
        """Poses of the base frame at some times in the base frame at a moment; None where odometry does not say."""
        poses = self._poses(np.concatenate([[moment_ns], times_ns]))
        if poses is None:
            return None
        relative: Array = invert_transform(poses[0]) @ poses[1:]
        return relative

    def deskewed(
        self, columns: Float32[Array, "3 n"], time_s: Float32[Array, " n"], stamp_ns: int
    ) -> Float32[Array, "3 n"] | None:
        """A sweep's points where they would have been measured had the robot stood still; None where that is unknown.

        Args:
            columns: x, y, z in the base frame at the time of each point, metres; at least one point.
            time_s: Time of each point from the stamp.
            stamp_ns: When the robot is to have stood still.
        """
        knots = np.linspace(float(time_s.min()), float(time_s.max()) + 1e-6, _KNOTS)
        poses = self.relative_to(stamp_ns, stamp_ns + np.rint(knots * 1e9).astype(np.int64))
        return None if poses is None else deskewed(columns, time_s, knots, poses)

    def _poses(self, times_ns: Int64[Array, " k"]) -> Float64[Array, "k 4 4"] | None:
        around = brackets(self.stamps_ns, times_ns, self.max_gap_s)
        if not around.valid.all():
            return None
        xyz = around.linear(self.xyz_m)
        attitude = slerp(self.quaternions[around.before], self.quaternions[around.after], around.weight)
        if not (np.isfinite(xyz).all() and np.isfinite(attitude).all()):
            return None
        return transform_from_xyz_quaternion(xyz, attitude)
