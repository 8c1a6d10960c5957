"""The ground's plane as the feet have felt it: the only thing the controller knows of the terrain ahead."""

import math
from collections.abc import Sequence

_STEEPEST = 0.6


class SupportPlane:
    """A plane through the places where the feet last stood, along the body's heading.

    Args:
        lag_s: Time constant with which the plane follows the feet; above 0.
    """

    def __init__(self, lag_s: float) -> None:
        self._lag_s = lag_s
        self.slope_forward = 0.0
        """Rise a metre ahead."""
        self.slope_left = 0.0
        """Rise a metre to the left."""
        self._level_m = 0.0
        self._middle = (0.0, 0.0)
        self._heading = (1.0, 0.0)

    def follow(self, feet_m: Sequence[Sequence[float]], heading: tuple[float, float], step_s: float) -> None:
        """Follow the places where the feet last stood.

        Args:
            feet_m: World x, y, z by leg.
            heading: Cosine and sine of the body's yaw.
            step_s: Since the last call; infinite takes the feet's places at once.
        """
        share = 1.0 - math.exp(-step_s / self._lag_s)
        cosine, sine = heading
        (ax, ay, az), (bx, by, bz), (cx, cy, cz), (dx, dy, dz) = feet_m
        long = 0.5 * (cosine * (ax + bx - cx - dx) + sine * (ay + by - cy - dy))
        wide = 0.5 * (cosine * (ay + cy - by - dy) - sine * (ax + cx - bx - dx))
        forward = 0.5 * (az + bz - cz - dz) / max(0.2, long)
        sideways = 0.5 * (az + cz - bz - dz) / max(0.1, wide)
        self.slope_forward += share * (min(max(forward, -_STEEPEST), _STEEPEST) - self.slope_forward)
        self.slope_left += share * (min(max(sideways, -_STEEPEST), _STEEPEST) - self.slope_left)
        self._level_m += share * (0.25 * (az + bz + cz + dz) - self._level_m)
        self._middle = (0.25 * (ax + bx + cx + dx), 0.25 * (ay + by + cy + dy))
        self._heading = heading

    def height(self, x_m: float, y_m: float) -> float:
        """Return the plane's world z at a place in the world."""
        dx, dy = x_m - self._middle[0], y_m - self._middle[1]
        cosine, sine = self._heading
        return (
            self._level_m + self.slope_forward * (cosine * dx + sine * dy) + self.slope_left * (cosine * dy - sine * dx)
        )
