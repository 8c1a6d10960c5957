"""All that an odometry said along a recording, as one table."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from navtool.datasets.streams.motion import Motion
from navtool.pipeline.arrays import Array

_UNSET_NORM = 1e-6


@dataclass(frozen=True, slots=True)
class OdometryTable:
    """Poses of the base frame in the odometry frame, and its velocities in its own axes."""

    stamps_ns: Int64[Array, " n"]
    """Strictly increasing."""
    values: Float64[Array, "n 13"]
    """In the order of ``ODOMETRY_COLUMNS``: position, attitude (x, y, z, w), linear and angular velocity."""

    def motion(self, max_gap_s: float) -> Motion:
        """The robot's way by the rows that are finite; an attitude that was never set is level.

        Args:
            max_gap_s: Poses further apart than this are not interpolated between.
        """
        finite = np.isfinite(self.values).all(axis=1)
        attitude = self.values[finite, 3:7]
        unset = np.linalg.norm(attitude, axis=1) < _UNSET_NORM
        attitude = np.where(unset[:, None], np.array([0.0, 0.0, 0.0, 1.0]), attitude)
        return Motion(self.stamps_ns[finite], self.values[finite, :3], attitude, max_gap_s)
