"""How far apart the clocks of two sensors are, by the turning that both of them measured."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64
from numpy.lib.stride_tricks import sliding_window_view

from navtool.pipeline.arrays import Array

_LEAST_S = 6.0
"""Shorter than this no turning tells one moment from another."""
_LEAST_RATE_RADPS = 0.03
_LEAST_CORRELATION = 0.7
_LEAST_LEAD = 0.1
"""By so much the best offset has to beat every other one."""
_MOST_SD_S = 0.03
_MOST_GAP_S = 0.5
_STEPS_S = (0.01, 0.1)
_LEAST_WINDOW_S = 0.1
"""What poses are noisy by is small against the turn within it."""


class Turning(NamedTuple):
    """How far something has turned about one axis, in its own clock's time."""

    time_s: Float64[Array, " n"]
    """Strictly increasing."""
    angle_rad: Float64[Array, " n"]
    """Not wrapped."""


class TimeOffset(NamedTuple):
    """The offset of one clock against another."""

    lag_s: float
    """How much later, by its own stamps, the second shows what the first shows."""
    sd_s: float
    """Standard deviation of the lag."""
    correlation: float
    """Correlation of the two turning rates at that lag, in [-1, 1]."""
    scale: float
    """Turning rate of the second for one of the first."""


def time_offset(first: Turning, second: Turning, reach_s: float) -> TimeOffset | None:
    r"""The lag between two records of one motion; None where the motion does not tell it.

    Both are brought to turning rates over the same windows and correlated at every lag. The peak is placed between the
    lags by the parabola through its neighbours. What turns steadily, or the same again and again, tells no lag.

    .. math:: r(k) = \frac{\sum_i a_i b_{i+k}}{\sqrt{\sum_i a_i^2 \sum_i b_{i+k}^2}}

    Args:
        first: Of any rate.
        second: Of any rate; it may turn the other way round.
        reach_s: The largest lag looked for, either way.

    Note:
        The standard deviation is the bound for a signal in white noise, :math:`\sqrt{(1 - r^2) / (r^2 N)} / \omega`
        with N independent windows and :math:`\omega` the root mean square frequency.
    """
    step_s = float(np.clip(max(_step(first), _step(second)) / 2, *_STEPS_S))
    start, end = (edge(first.time_s[at], second.time_s[at]) for edge, at in ((max, 0), (min, -1)))
    if end - start < _LEAST_S:
        return None
    window_s = max(_LEAST_WINDOW_S, 2 * step_s, _step(first), _step(second))
    at = np.arange(start + window_s / 2, end - window_s / 2, step_s)
    rate_a, known_a = _rates(first, at, window_s)
    rate_b, known_b = _rates(second, at, window_s)
    if min(_deviation(rate_a, known_a), _deviation(rate_b, known_b)) < _LEAST_RATE_RADPS:
        return None
    a, b = (np.where(known, rate - rate[known].mean(), 0.0) for rate, known in ((rate_a, known_a), (rate_b, known_b)))
    most = int(min(reach_s / step_s, a.size / 3))
    correlation = _correlation(a, b, most)
    peak = int(np.argmax(np.abs(correlation)))
    height = float(correlation[peak])
    if abs(height) < _LEAST_CORRELATION or peak in (0, correlation.size - 1):
        return None
    size = np.abs(correlation)
    if size[_outside_lobe(size, peak)].max(initial=0.0) > abs(height) - _LEAST_LEAD:
        return None
    left, middle, right = size[peak - 1 : peak + 2]
    between = 0.5 * (left - right) / min(left - 2 * middle + right, -1e-12)
    overlap_a, overlap_b = _overlap(a, b, peak - most)
    frequency = float(np.sqrt((np.diff(a) ** 2).sum() / (a**2).sum())) / step_s
    windows = max(at.size * step_s / window_s, 1.0)
    sd_s = float(np.sqrt((1 - min(height**2, 1.0)) / (height**2 * windows)) / frequency)
    if sd_s > _MOST_SD_S:
        return None
    scale = float((overlap_a * overlap_b).sum() / (overlap_a**2).sum())
    return TimeOffset((peak - most + float(between)) * step_s, sd_s, height, scale)


def _step(turning: Turning) -> float:
    return float(np.median(np.diff(turning.time_s)))


def _rates(
    turning: Turning, at: Float64[Array, " k"], window_s: float
) -> tuple[Float64[Array, " k"], Bool[Array, " k"]]:
    """Mean turning rates over windows around some moments, and whether they are known there."""
    before, after = (np.interp(at + side * window_s / 2, turning.time_s, turning.angle_rad) for side in (-1, 1))
    following = np.searchsorted(turning.time_s, at).clip(1, turning.time_s.size - 1)
    gap_s = turning.time_s[following] - turning.time_s[following - 1]
    return (after - before) / window_s, gap_s <= max(_MOST_GAP_S, 2 * _step(turning))


def _deviation(rate: Float64[Array, " k"], known: Bool[Array, " k"]) -> float:
    return float(rate[known].std()) if known.sum() > 1 else 0.0


def _correlation(a: Float64[Array, " k"], b: Float64[Array, " k"], most: int) -> Float64[Array, " lags"]:
    """Normalised correlation at lags of -most to most steps."""
    size = 1 << int(2 * a.size - 1).bit_length()
    raw = np.fft.irfft(np.conj(np.fft.rfft(a, size)) * np.fft.rfft(b, size), size)
    lags = np.arange(-most, most + 1)
    power_a, power_b = (np.concatenate([[0.0], np.cumsum(x**2)]) for x in (a, b))
    low, high = np.maximum(-lags, 0), a.size - np.maximum(lags, 0)
    of_a, of_b = power_a[high] - power_a[low], power_b[high + lags] - power_b[low + lags]
    found: Array = raw[lags] / np.sqrt(np.maximum(of_a * of_b, 1e-30))
    return found


def _overlap(
    a: Float64[Array, " k"], b: Float64[Array, " k"], lag: int
) -> tuple[Float64[Array, " m"], Float64[Array, " m"]]:
    """What both say of the same moments."""
    return (a[: a.size - lag], b[lag:]) if lag >= 0 else (a[-lag:], b[: b.size + lag])


def _outside_lobe(size: Float64[Array, " lags"], peak: int) -> Bool[Array, " lags"]:
    """The lags beyond the valleys on both sides of the peak."""
    outside = np.ones(size.size, dtype=np.bool_)
    low, high = peak, peak
    while low > 0 and size[low - 1] <= size[low]:
        low -= 1
    while high < size.size - 1 and size[high + 1] <= size[high]:
        high += 1
    outside[low : high + 1] = False
    return outside


def busiest(turning: Turning, length_s: float) -> tuple[float, float]:
    """The stretch of a length in which the turning changes most: from, to."""
    start, end = float(turning.time_s[0]), float(turning.time_s[-1])
    if end - start <= length_s:
        return start, end
    at = np.arange(start, end, 0.5)
    rate = np.diff(np.interp(at, turning.time_s, turning.angle_rad)) / 0.5
    windows = sliding_window_view(rate, min(int(length_s / 0.5), rate.size))
    first = float(at[int(np.argmax(windows.std(axis=1)))])
    return first, first + length_s
