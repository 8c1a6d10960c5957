"""Which sign a discharging current has in a recording whose robot does not say."""

from typing import NamedTuple

import numpy as np

from navtool.base.note import Note
from navtool.datasets.streams.timed_stream import TimedStream

_AS_DEFINED = -1
"""sensor_msgs/BatteryState: negative while discharging."""


class DischargeSign(NamedTuple):
    """The sign, and what a user should know about it."""

    sign: int
    notes: tuple[Note, ...] = ()


def discharge_sign(configured: int, battery: TimedStream | None) -> DischargeSign:
    """The sign of a discharge: -1 or 1.

    A robot in use draws from its battery for most of a recording, so the median current is a discharge. Where it is 0
    the sign stays that of sensor_msgs.

    Args:
        configured: The robot's setting; 0 where the sign is not known.
        battery: The battery's messages, as recorded.
    """
    if configured != 0 or battery is None:
        return DischargeSign(configured or _AS_DEFINED)
    current = battery.columns("current_a")
    finite = current[np.isfinite(current)]
    if not finite.size:
        return DischargeSign(_AS_DEFINED)
    median_a = float(np.median(finite))
    unsaid = "battery: the robot file leaves the sign of a discharge open"
    if median_a == 0:
        what = f"{unsaid} and the median current is 0; a negative one counts as discharge"
        return DischargeSign(_AS_DEFINED, (Note("battery.sign-unknown", what),))
    what = f"{unsaid}; the median of {median_a:.1f} A is taken for one"
    return DischargeSign(1 if median_a > 0 else -1, (Note("battery.sign-by-median", what),))
