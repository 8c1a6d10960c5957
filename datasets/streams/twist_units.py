"""The unit of recorded velocities, by how much larger they are than the poses say."""

from typing import NamedTuple

_MPS = {"km/h": 3.6, "cm/s": 100.0, "mm/s": 1000.0, "mph": 2.236936, "knots": 1.943844}
_RADPS = {"deg/s": 57.29578, "rpm": 9.549297}
_SAME_UNIT = 1.06
_AGREE = 1.25
"""Factors up to here are the odometry's own: slipping wheels, a radius that is not quite right."""
_SOME_UNIT = 3.0
"""A steady factor beyond this is a unit, whichever."""


class Unit(NamedTuple):
    """What recorded velocities are to be divided by."""

    name: str
    """Empty where they are in metres and radians a second."""
    factor: float


def unit_of(factor: float, *, turning: bool) -> Unit | None:
    """The unit of velocities that are larger by a factor than they should be; None where nothing tells.

    Args:
        factor: Above 0.
        turning: Whether they are turning rates.
    """
    if 1 / _AGREE <= factor <= _AGREE:
        return Unit("", 1.0)
    for name, known in (_RADPS if turning else _MPS).items():
        if known / _SAME_UNIT <= factor <= known * _SAME_UNIT:
            return Unit(name, known)
    return Unit("a unit of its own", factor) if factor > _SOME_UNIT or factor < 1 / _SOME_UNIT else None
