"""Recorded velocities against poses, over windows of a whole recording."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from navtool.datasets.streams.pose_travel import PoseTravel
from navtool.pipeline.arrays import Array

LEAST_WINDOW_S = 1.0
"""Travel is compared over so long at least: noise and jitter are small against it."""
_MOST_WINDOW_S = 8.0
_LEAST_POSES = 4
_GAP_PERIODS = 5.0
SLOWEST = np.array([0.1, 0.1, 0.1])
"""Slower motion is none: forward, left in m/s, turn in rad/s."""


@dataclass(frozen=True, slots=True)
class Windows:
    """Windows of a recording, one from each pose on; none spans a pause.

    Attributes:
        start: Poses at which they begin.
        end: Poses at which they end.
        length_s: How long each lasts.
    """

    start: Int64[Array, " windows"]
    end: Int64[Array, " windows"]
    length_s: Float64[Array, " windows"]

    def over(self, travel: Float64[Array, "n columns"]) -> Float64[Array, "windows columns"]:
        """What was travelled within each."""
        return travel[self.end] - travel[self.start]

    def moving(self, travel: PoseTravel, *amounts: Float64[Array, "windows columns"]) -> Bool[Array, "windows columns"]:
        """Where one of the amounts is motion, beyond the noise of the poses; by column."""
        columns = amounts[0].shape[1]
        least = SLOWEST[:columns] * self.length_s[:, None] + 6 * travel.noise[:columns]
        return np.asarray(np.max([np.abs(amount) for amount in amounts], axis=0) > least)


def windows(travel: PoseTravel, most_s: float = _MOST_WINDOW_S) -> Windows:
    """Windows in which the robot, where it moves, moves far beyond the noise of its poses; a second where that does.

    Args:
        most_s: The longest that one may last.
    """
    length_s = max(LEAST_WINDOW_S, _LEAST_POSES * travel.period_s)
    while True:
        found = _of_length(travel.time_s, length_s, travel.period_s)
        moved = np.linalg.norm(found.over(travel.travel)[:, :2], axis=1)
        moving = moved[moved > 6 * travel.noise[0] + SLOWEST[0] * length_s]
        if moving.size > len(moved) / 10 or travel.noise[0] < 0.01 or 2 * length_s > most_s:
            return found
        length_s *= 2


def local_windows(travel: PoseTravel, length_s: float) -> Windows:
    """Windows of a fixed length."""
    return _of_length(travel.time_s, max(length_s, _LEAST_POSES * travel.period_s), travel.period_s)


def _of_length(time_s: Float64[Array, " n"], length_s: float, period_s: float) -> Windows:
    end = np.searchsorted(time_s, time_s + length_s - period_s / 4)
    start = np.flatnonzero(end < time_s.size)
    end = end[start]
    pauses = np.concatenate([[0], np.cumsum(np.diff(time_s) > max(_GAP_PERIODS * period_s, LEAST_WINDOW_S))])
    whole = pauses[end] == pauses[start]
    start, end = start[whole], end[whole]
    return Windows(start, end, time_s[end] - time_s[start])


def summed(speeds: Float64[Array, "n columns"], time_s: Float64[Array, " n"]) -> Float64[Array, "n columns"]:
    """Speeds summed up over time (by trapezoids) from the first moment on; what is not finite counts as 0."""
    known = np.nan_to_num(speeds, nan=0.0, posinf=0.0, neginf=0.0)
    steps = (known[1:] + known[:-1]) / 2 * np.diff(time_s)[:, None]
    return np.concatenate([np.zeros((1, speeds.shape[1])), np.cumsum(steps, axis=0)])
