"""Does an accelerometer measure gravity as one in the base frame's axes does?"""

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array

STANDARD_MPS2 = 9.80665
_TILT_RAD = np.radians(30.0)
"""No outdoor robot stands tilted further than this on average."""
_SHARE = 0.2
_LEAST = 20


def odd_gravity(acceleration_mps2: Float64[Array, "samples 3"]) -> str | None:
    """What is odd about the mean specific force in base axes, and the cure; None where it is upwards and 9.81 m/s2.

    At rest an accelerometer measures +9.81 m/s2 along the axis that points up (REP-103: z). Over a run the robot's own
    accelerations cancel out, so the mean shows how the sensor is mounted and in which unit it measures.

    Args:
        acceleration_mps2: As recorded; rows with NaN are left out.
    """
    finite = acceleration_mps2[np.isfinite(acceleration_mps2).all(axis=1)]
    if len(finite) < _LEAST:
        return None
    mean = finite.mean(axis=0)
    size = float(np.linalg.norm(mean))
    if abs(size - 1.0) < _SHARE:
        return f"mean acceleration {size:.2f}: recorded in g, not in m/s2? Values are left as recorded"
    if not abs(size - STANDARD_MPS2) < _SHARE * STANDARD_MPS2:
        return f"mean acceleration {size:.2f} m/s2, not gravity's {STANDARD_MPS2:.2f}: taken out by the driver?"
    if np.arccos(np.clip(mean[2] / size, -1.0, 1.0)) <= _TILT_RAD:
        return None
    axis = int(np.argmax(np.abs(mean)))
    sign = "-" if mean[axis] < 0 else "+"
    return f"gravity is along {sign}{'xyz'[axis]}, not +z: mounted turned? Give its pose by tf or mounting.imu"
