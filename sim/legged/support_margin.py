"""How far inside the feet that will carry it the body is, before and while one foot steps."""

import math
from collections.abc import Sequence
from typing import NamedTuple

_MOST_M = 0.12


class Inward(NamedTuple):
    """How far the body has to move to be far enough inside. World frame, metres."""

    x_m: float
    y_m: float


def inward(feet_m: Sequence[Sequence[float]], leg: int, centre_m: tuple[float, float], wanted_m: float) -> Inward:
    """Return the shortest way over the ground that brings the body inside the triangle of the three other feet.

    A foot that came down early on a stone, or late in a hole, is not where the gait's table has it: the body then
    would tip over the line between the two feet beside the stepping one.

    Args:
        feet_m: Where the feet stand, world x and y first, by leg in the order of `body.LEGS`.
        leg: The foot that steps.
        centre_m: World x and y of the point to be kept inside.
        wanted_m: Distance from that line at which it is inside enough; 0 or more.
    """
    first, second = (other for other in range(4) if other not in (leg, 3 - leg))
    (ax, ay), (bx, by), (ox, oy) = (feet_m[foot][:2] for foot in (first, second, 3 - leg))
    length = math.hypot(bx - ax, by - ay)
    if length < 1e-3:
        return Inward(0.0, 0.0)
    nx, ny = (ay - by) / length, (bx - ax) / length
    if nx * (ox - ax) + ny * (oy - ay) < 0.0:
        nx, ny = -nx, -ny
    inside = nx * (centre_m[0] - ax) + ny * (centre_m[1] - ay)
    short = min(max(wanted_m - inside, 0.0), _MOST_M)
    return Inward(nx * short, ny * short)
