"""How high a sensor is above the ground, measured where it is not known."""

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array

_NEAR_M, _LOWEST_PERCENT = 5.0, 5.0


def height_above_ground(xyz: Float32[Array, "p 3"]) -> float | None:
    """Height in metres above the lowest twentieth of the points within 5 m; None where none of them lies below.

    Args:
        xyz: Points around the sensor, its z axis up.
    """
    near = xyz[np.hypot(xyz[:, 0], xyz[:, 1]) < _NEAR_M, 2]
    height = -float(np.percentile(near, _LOWEST_PERCENT)) if near.size else 0.0
    return height if height > 0 else None
