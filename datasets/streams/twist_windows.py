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
SLOWEST = 0.1
"""Slower motion is none, in m/s and rad/s,"""
_USUAL = 0.25
"""but of a robot that is slow itself: there less than such a share of its usual motion is none,"""
_DRIFT = 0.02
"""and what poses drift by."""
_NOISES = 6.0
_FAR = 3.0
"""So many times what counts as motion the usual one is to be within a window."""


@dataclass(frozen=True, slots=True)
class Windows:
    """Windows of a recording, one from each pose on; none spans a pause.

    Attributes:
        start: Poses at which they begin.
        end: Poses at which they end.
        length_s: How long each lasts.
        usual: How fast the robot usually moves where it does, forward and left in m/s, turning in rad/s.
        noise: Standard deviation of a single pose, in metres (twice) and radians.
    """

    start: Int64[Array, " windows"]
    end: Int64[Array, " windows"]
    length_s: Float64[Array, " windows"]
    usual: Float64[Array, " 3"]
    noise: Float64[Array, " 3"]

    def over(self, travel: Float64[Array, "n columns"]) -> Float64[Array, "windows columns"]:
        """What was travelled within each."""
        return travel[self.end] - travel[self.start]

    def least(self) -> Float64[Array, "windows 3"]:
        """What counts as motion within each, beyond the noise of the poses: metres, metres, radians."""
        slowest = np.clip(_USUAL * self.usual, _DRIFT, SLOWEST)
        return np.asarray(slowest * self.length_s[:, None] + _NOISES * self.noise)

    def far(self) -> Float64[Array, " 3"]:
        """How many times what counts as motion the usual one is."""
        if not self.start.size:
            return np.zeros(3)
        return np.asarray(self.usual * self.length_s.mean() / self.least().mean(axis=0))

    def moving(self, *amounts: Float64[Array, "windows 3"]) -> Bool[Array, "windows 3"]:
        """Where one of the amounts is motion; by column."""
        return np.asarray(np.max([np.abs(amount) for amount in amounts], axis=0) > self.least())


def windows(travel: PoseTravel, *, turning: bool = False) -> Windows:
    """The shortest windows in which the usual motion is far beyond the noise of the poses, or those where it is most.

    A second where it is within the noise in all.

    Args:
        turning: Whether it is the turning that is looked at.
    """
    best, most, length_s = local_windows(travel, LEAST_WINDOW_S), 1.0, LEAST_WINDOW_S
    while length_s <= _MOST_WINDOW_S and most < _FAR:
        found = local_windows(travel, length_s)
        far = found.far()[2 if turning else 0]
        best, most = (found, far) if far > most else (best, most)
        length_s *= 2
    return best


def local_windows(travel: PoseTravel, length_s: float) -> Windows:
    """Windows of a fixed length."""
    length_s, period_s, time_s = max(length_s, _LEAST_POSES * travel.period_s), travel.period_s, travel.time_s
    end = np.searchsorted(time_s, time_s + length_s - period_s / 4)
    start = np.flatnonzero(end < time_s.size)
    end = end[start]
    pauses = np.concatenate([[0], np.cumsum(np.diff(time_s) > max(_GAP_PERIODS * period_s, LEAST_WINDOW_S))])
    whole = pauses[end] == pauses[start]
    start, end = start[whole], end[whole]
    lasts_s = time_s[end] - time_s[start]
    return Windows(start, end, lasts_s, _usual(travel.travel[end] - travel.travel[start], lasts_s), travel.noise)


def _usual(travel: Float64[Array, "windows 3"], lasts_s: Float64[Array, " windows"]) -> Float64[Array, " 3"]:
    """Means of speed and turning rate, weighted by themselves, so that pauses do not count."""
    rates = np.column_stack([np.hypot(travel[:, 0], travel[:, 1]), np.abs(travel[:, 2])]) / lasts_s[:, None]
    return np.asarray(((rates**2).sum(axis=0) / np.maximum(rates.sum(axis=0), 1e-12))[[0, 0, 1]])


def summed(speeds: Float64[Array, "n columns"], time_s: Float64[Array, " n"]) -> Float64[Array, "n columns"]:
    """Speeds summed up over time (by trapezoids) from the first moment on; what is not finite counts as 0."""
    known = np.nan_to_num(speeds, nan=0.0, posinf=0.0, neginf=0.0)
    steps = (known[1:] + known[:-1]) / 2 * np.diff(time_s)[:, None]
    return np.concatenate([np.zeros((1, speeds.shape[1])), np.cumsum(steps, axis=0)])
