"""Recorded speeds forward and to the left, brought into metres a second along the body's own axes."""

import numpy as np
from jaxtyping import Complex128

from navtool.base.note import Note
from navtool.datasets.streams.odometry_heading import ASIDE
from navtool.datasets.streams.twist_comparison import FASTEST_MPS, LEAST_TRAVEL, TwistComparison
from navtool.datasets.streams.twist_units import unit_of
from navtool.datasets.streams.twist_ways import (
    FIT,
    ONE_WAY,
    STEADY,
    TURNED,
    both_move,
    fitting,
    middle,
    misfit,
    plane,
    unit_note,
)
from navtool.datasets.streams.twist_windows import summed
from navtool.pipeline.arrays import Array

_LEAST_TURN_RAD = 0.35
"""A smaller angle between velocity and way is left as it is."""
_SQUARE_RAD = 0.12
"""An angle so near to a quarter turn is one."""


def mend_linear(columns: TwistComparison) -> None:
    """Bring the speeds forward and to the left into metres a second along the body's own axes."""
    way, measured = plane(columns.by_poses), plane(columns.by_twist)
    moves = both_move(way, measured, columns.least_m)
    if not columns.last_enough(moves):
        return
    way, measured, least = way[moves], measured[moves], columns.least_m[moves]
    if not np.nan_to_num(columns.speeds[:, 1]).any() and fitting(way.real + 0j, measured, least) > FIT:
        return
    if fitting(way, measured, least) > FIT:
        return
    candidates = [(middle(way, seen) * seen, mirror) for seen, mirror in ((measured, False), (measured.conj(), True))]
    straight, mirrored = (misfit(way, seen) for seen, _ in candidates)
    mirror = mirrored < straight / 2
    seen = measured.conj() if mirror else measured
    factor = middle(way, seen)
    unit = unit_of(1 / max(abs(factor), 1e-12), turning=False)
    if min(straight, mirrored) > STEADY:
        columns.leave([0, 1], "its speeds and its poses say different ways, and nothing tells why")
    elif np.quantile(np.abs(way) / columns.found.length_s[moves], 0.9) > FASTEST_MPS:
        columns.leave([0, 1], f"its poses move faster than {FASTEST_MPS:g} m/s: they are in another unit than metres")
    elif unit is None:
        columns.leave([0, 1], f"its speeds are {1 / abs(factor):.2f} times as large as its poses say")
    else:
        angle = float(np.angle(factor))
        if (abs(angle) > _LEAST_TURN_RAD or mirror) and not _turn(columns, way, measured, angle, mirror=mirror):
            return
        if unit.name:
            columns.speeds[:, :2] /= unit.factor
            columns.notes.append(unit_note("speeds", unit.name, unit.factor, "m/s"))


def _turn(
    columns: TwistComparison,
    way: Complex128[Array, " w"],
    measured: Complex128[Array, " w"],
    angle: float,
    *,
    mirror: bool,
) -> bool:
    """Turn the speeds onto the way, where it is they that look aside; whether nothing is left to tell."""
    nearest = round(angle / (np.pi / 2)) * (np.pi / 2)
    angle = nearest if abs(angle - nearest) < _SQUARE_RAD else angle
    shown = f"{abs(np.degrees(angle)):.0f} deg to the {'left' if angle < 0 else 'right'} of the way of its poses"
    if mirror:
        shown = "as in a mirror of the way of its poses"
    elif abs(angle) > np.pi - _SQUARE_RAD:
        shown = "backwards by the way of its poses"
    if _twist_is_wrong(columns, way, measured):
        linear = columns.speeds[:, 0] + 1j * columns.speeds[:, 1]
        linear = (linear.conj() if mirror else linear) * np.exp(1j * angle)
        columns.speeds[:, 0], columns.speeds[:, 1] = linear.real, linear.imag
        what = f"odometry: its speeds point {shown}; turned onto it"
        columns.notes.append(Note(TURNED, what))
        return True
    if not mirror and _twist_is_wrong(columns, measured, way, turned_round=True):
        columns.undecided[:2] = True
        # By how much poses look aside is said where their way is looked at.
        if abs(angle) > np.pi - _LEAST_TURN_RAD:
            what = (
                "odometry: the robot moves backwards by where its poses look; if it does not drive backwards, its "
                f"odometry_yaw_rad lacks {np.pi:.3f}"
            )
            columns.notes.append(Note(ASIDE, what))
        return True
    columns.leave([0, 1], f"its speeds point {shown}, and nothing tells which of them is right")
    return False


def _twist_is_wrong(
    columns: TwistComparison,
    way: Complex128[Array, " w"],
    measured: Complex128[Array, " w"],
    *,
    turned_round: bool = False,
) -> bool:
    """Whether a robot would rather move as the way says than as the velocities do: along, forward, as commanded.

    Args:
        turned_round: Whether way and velocities have changed their places.
    """
    along, along_measured = (float(np.abs(x.real).sum() / np.abs(x).sum()) for x in (way, measured))
    if along - along_measured > ONE_WAY:
        return True
    if along_measured - along > ONE_WAY:
        return False
    asked = _asked(columns)
    if asked is not None:
        return (asked[1] if turned_round else asked[0]) > ONE_WAY
    return bool(way.real.sum() > ONE_WAY * np.abs(way).sum() and way.real.sum() > measured.real.sum())


def _asked(columns: TwistComparison) -> tuple[float, float] | None:
    """How far poses and speeds go the way that was commanded, as shares of it; None without commands."""
    command = columns.witnesses.command_mps
    if command is None:
        return None
    asked = columns.found.over(summed(command[:, None], columns.travel.time_s))[:, 0]
    ways = columns.by_poses[:, 0], columns.by_twist[:, 0]
    if np.abs(asked).sum() * columns.travel.period_s < LEAST_TRAVEL[0]:
        return None
    agree = [float((way * asked).sum() / max(np.linalg.norm(way) * np.linalg.norm(asked), 1e-12)) for way in ways]
    return None if max(map(abs, agree)) < ONE_WAY else (agree[0], agree[1])
