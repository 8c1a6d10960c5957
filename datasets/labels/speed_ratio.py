"""Whether an odometry's poses and speeds agree on the motion."""

import numpy as np
from jaxtyping import Bool, Float

from navtool.pipeline.arrays import Array

MOVING_MPS = 0.2
"""Slower rows are left out: noise of the poses would count as motion."""
LEAST_ROWS = 20


def speed_ratio(
    pose: Float[Array, "rows 3"], state: Float[Array, "rows 2"], valid: Bool[Array, " rows"], fps: int
) -> float | None:
    """Distance driven by the poses over distance driven by the measured speeds; 1 where both agree.

    Args:
        pose: [x_m, y_m, yaw_rad] of each row.
        state: [v_mps, omega_radps] of each row.
        valid: Whether both were measured.
        fps: Rows per second.

    Returns:
        None where the robot moves in too few rows to compare.
    """
    speed = np.abs(state[:, 0].astype(np.float64))
    moving = valid[:-1] & valid[1:] & (speed[:-1] > MOVING_MPS) & (speed[1:] > MOVING_MPS)
    if moving.sum() < LEAST_ROWS:
        return None
    steps_m = np.linalg.norm(np.diff(pose[:, :2].astype(np.float64), axis=0), axis=1)
    by_speed_m = (speed[:-1] + speed[1:]) / 2 / fps
    return float(steps_m[moving].sum() / by_speed_m[moving].sum())
