"""Taking the robot's own motion during a sweep out of a LiDAR cloud."""

import numpy as np
from jaxtyping import Float, Float32, Float64

from navtool.pipeline.arrays import Array


def deskewed(
    columns: Float32[Array, "3 n"],
    time_s: Float32[Array, " n"],
    knots_s: Float64[Array, " k"],
    motion: Float64[Array, "k 4 4"],
) -> Float32[Array, "3 n"]:
    """Points where they would have been measured had the robot stood still at the cloud's stamp.

    Between two knots the transforms are blended linearly: over the 6 ms of a sixteenth of a sweep at 2 rad/s that is
    off by 2e-5 of a point's distance.

    Args:
        columns: x, y, z in the base frame at the time of each point, metres.
        time_s: Time of each point from the cloud's stamp, seconds; beyond the knots the outermost holds.
        knots_s: Increasing times, at least two.
        motion: Pose of the base frame at each knot in the base frame at the stamp.
    """
    knot = np.interp(time_s, knots_s, np.arange(len(knots_s)))
    before = np.minimum(knot.astype(np.int64), len(knots_s) - 2)
    share = (knot - before).astype(np.float32)
    rows = motion[:, :3].astype(np.float32)
    moved: Float[Array, "3 n"] = np.zeros_like(columns)
    for knot in np.unique(before).tolist():
        at = np.flatnonzero(before == knot)
        points = columns[:, at]
        first, second = (part[:, :3] @ points + part[:, 3:] for part in rows[knot : knot + 2])
        moved[:, at] = first + share[at] * (second - first)
    return moved
