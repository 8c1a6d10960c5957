"""Parts of recorded velocities that were never filled in."""

import numpy as np
from jaxtyping import Bool

from navtool.base.note import Note
from navtool.datasets.streams.twist_comparison import FASTEST_MPS, LEAST_TRAVEL, TwistComparison
from navtool.datasets.streams.twist_ways import FIT, fitting
from navtool.pipeline.arrays import Array

_NAMES = ("vx", "vy", "wz")
_SIDEWAYS = 0.2
"""A robot whose travel to the side is a smaller share of the one forward does not move sideways,"""
_ASIDE = 0.5
"""unless it does for a while, by more than such a share."""
_NOTHING = 0.01
"""A velocity that never reaches such a share of the usual one was not filled in: rounding leaves as much."""


def fill_empty(columns: TwistComparison) -> None:
    """Take parts from the poses that are zero in every message."""
    total = columns.travelled()
    empty = _empty(columns)
    fill = empty & (total > LEAST_TRAVEL)
    if empty[:2].all():
        fill[:2] = fill[:2].any()
    else:
        # A velocity aside of the way is not one of which a part is missing.
        alone = columns.found.moving(columns.by_poses, columns.by_twist)[:, 0]
        fits = fitting(columns.by_poses[alone, 0] + 0j, columns.by_twist[alone, 0] + 0j, columns.least_m[alone])
        fill[0] = False
        fill[1] &= (bool(total[1] > _SIDEWAYS * total[0]) or _goes_aside(columns)) and fits > FIT
    if not fill.any():
        return
    columns.speeds[:, fill] = columns.travel.speeds()[:, fill]
    columns.taken |= fill
    if empty.all():
        what = f"state: every twist is 0 while the poses move {np.hypot(*total[:2]):.1f} m and turn {total[2]:.1f} rad"
        columns.notes.append(Note("state.no-twist", f"{what}; speeds are differences of poses"))
        return
    parts = " and ".join(name for name, taken in zip(_NAMES, fill, strict=True) if taken)
    amount = f"{np.hypot(*total[:2]):.1f} m" if fill[:2].any() else f"{total[2]:.1f} rad"
    zero = "are" if fill.sum() > 1 else "is"
    what = f"odometry: {parts} {zero} 0 in every message while the poses move {amount}; taken from the poses"
    columns.notes.append(Note("odometry.twist-part", what))


def _goes_aside(columns: TwistComparison) -> bool:
    """Whether the robot goes to the side for a while."""
    forward, left = np.abs(columns.by_poses[:, :2].T)
    return columns.last_enough((left > _ASIDE * forward) & (left > 2 * columns.least_m))


def _empty(columns: TwistComparison) -> Bool[Array, " 3"]:
    """Which velocities are nothing beside the usual ones of the poses."""
    rates = np.abs(columns.by_poses) / columns.found.length_s[:, None]
    usual = np.quantile(np.column_stack([np.hypot(rates[:, 0], rates[:, 1]), rates[:, 2]]), 0.95, axis=0)[[0, 0, 1]]
    largest = np.abs(np.nan_to_num(columns.speeds)).max(axis=0)
    # Poses in another unit than metres are no measure of what is nothing.
    usual[:2] = np.where(usual[:2] < FASTEST_MPS, usual[:2], 0.0)
    return np.asarray(largest <= _NOTHING * usual)
