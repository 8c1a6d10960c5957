"""How much a drive shakes the robot: the measures that figures and papers use."""

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array


def vibration_rms(specific_force_mps2: Float64[Array, "n 3"], settle: int) -> float:
    """Return the root mean square in m/s2 of what an IMU feels above gravity.

    Gravity is the mean specific force over the last `settle` samples: the body's slow lean on a slope is none of it.

    Args:
        specific_force_mps2: As measured, at least 2 `settle` of them; the first `settle` only set the mean.
        settle: Samples in about a second.
    """
    total = np.cumsum(specific_force_mps2, axis=0)
    mean = (total[settle:] - total[:-settle]) / settle
    shaken = specific_force_mps2[settle:] - mean
    return float(np.sqrt((shaken * shaken).sum(axis=1).mean()))
