"""Whether the intensities of a recording can carry an intensity map."""

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array

_SATURATED, _FAINTEST = 0.99, 0.02


def judge_intensities(intensity: Float32[Array, " p"], full_scale: float) -> str | None:
    """What is wrong with the intensities of a cloud, None if they can be used.

    Args:
        intensity: Of all points of one or several clouds.
        full_scale: R, what the configuration takes for the largest intensity.
    """
    known = intensity[np.isfinite(intensity)]
    if not known.size:
        return "no point has an intensity"
    largest = float(known.max())
    if float(known.min()) < 0:
        return f"the smallest intensity is {float(known.min()):g}: intensities are not negative"
    if largest <= 0:
        return "all intensities are 0: the driver does not fill them in"
    if not _FAINTEST * full_scale <= largest <= full_scale:
        return f"the largest intensity is {largest:g} where full_scale is {full_scale:g}: set the sensor's own scale"
    saturated = float((known >= full_scale).mean())
    if saturated > _SATURATED:
        return f"{saturated:.0%} of the intensities are the largest there is: the sensor is saturated"
    return None
