"""Recorded turning rates, brought into radians a second to the left."""

import numpy as np

from navtool.base.note import Note
from navtool.datasets.streams.twist_comparison import TwistComparison
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
from navtool.datasets.streams.twist_windows import summed, windows


def mend_turning(columns: TwistComparison) -> None:
    """Bring the turning rate into radians a second, to the left."""
    travel = columns.travel
    found = windows(travel, turning=True)
    turned = found.over(travel.travel)[:, 2] + 0j
    measured = found.over(summed(columns.speeds[:, 2:], travel.time_s))[:, 0] + 0j
    least = found.least()[:, 2]
    if not found.start.size:
        return
    moves = both_move(turned, measured, least)
    if not columns.last_enough(moves, found) or fitting(turned[moves], measured[moves], least[moves]) > FIT:
        return
    turned, measured = turned[moves], measured[moves]
    factor = middle(turned, measured)
    unit = unit_of(1 / max(abs(factor), 1e-12), turning=True)
    if misfit(turned, factor * measured) > STEADY:
        columns.leave([2], "its turning rate and its poses say different turns, and nothing tells why")
    elif unit is None:
        columns.leave([2], f"its turning rate is {1 / abs(factor):.2f} times as large as its poses say")
    else:
        if factor.real < 0:
            if not _poses_turn_rightly(columns):
                columns.leave(
                    [2], "it turns to the other side than its poses, and nothing tells which of them is right"
                )
                return
            columns.speeds[:, 2] *= -1
            what = "odometry: its turning rate has the other sign than the turns of its poses; turned round"
            columns.notes.append(Note(TURNED, what))
        if unit.name:
            columns.speeds[:, 2] /= unit.factor
            columns.notes.append(unit_note("turning rates", unit.name, unit.factor, "rad/s"))


def _poses_turn_rightly(columns: TwistComparison) -> bool:
    """Whether the gyroscope turns as the poses do, or without one their own way bends as they turn."""
    turned = columns.by_poses[:, 2]
    if columns.witnesses.gyro_radps is not None:
        seen = columns.found.over(summed(columns.witnesses.gyro_radps[:, None], columns.travel.time_s))[:, 0]
    else:
        steps = plane(columns.by_poses) * 0
        half = (columns.found.start + columns.found.end) // 2
        way = columns.travel.way_m
        before, after = plane(way[half] - way[columns.found.start]), plane(way[columns.found.end] - way[half])
        far = np.minimum(np.abs(before), np.abs(after)) > columns.least_m
        steps[far] = after[far] * before[far].conj() / np.abs(after[far] * before[far])
        seen = np.angle(np.where(far, steps, 1.0))
    scale = np.linalg.norm(seen) * np.linalg.norm(turned)
    return bool(scale > 0 and (seen * turned).sum() / scale > ONE_WAY)
