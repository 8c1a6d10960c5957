"""The path of one foot through the air, replanned all the way down."""

import math
from dataclasses import dataclass


@dataclass(slots=True)
class Swing:
    """A step that is under way. World frame, metres."""

    lift_off: tuple[float, float, float]
    """Where the foot stood."""
    height_m: float
    """How far it is lifted above the line between its footprints; grows when it is caught on something."""
    landed: bool = False
    """Whether it met the ground before its time."""
    caught: bool = False
    """Whether it was caught on something on its way."""

    def place(self, share: float, target: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return where the foot shall be after a share of the step, 0-1; at rest over the ground at both ends.

        It is lifted before it goes ahead, and comes down once it is nearly there.
        """
        ahead = _smooth(min(max((share - 0.08) / 0.80, 0.0), 1.0))
        x0, y0, z0 = self.lift_off
        x1, y1, z1 = target
        base = z0 + (z1 - z0) * _smooth(share)
        return x0 + ahead * (x1 - x0), y0 + ahead * (y1 - y0), base + self.height_m * _hump(share)


def _smooth(share: float) -> float:
    return share * share * (3.0 - 2.0 * share)


def _hump(share: float) -> float:
    """Rise to 1 at two fifths of the step and fall back."""
    if share <= 0.4:
        return _smooth(share / 0.4)
    return 0.5 + 0.5 * math.cos(math.pi * (share - 0.4) / 0.6)
