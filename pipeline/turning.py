"""How far a sensor turned between two of its clouds or pictures, as far as its clock is to be compared with another."""

import cv2
import numpy as np
from jaxtyping import Float32, Float64, UInt8

from navtool.pipeline.arrays import Array

_BINS = 720
_MOST_TURN_RAD = 0.8
_NEAREST_M = 0.5
_PICTURE_PX = (160, 120)
_FITS = 5
_AZIMUTH = (np.arange(_BINS) + 0.5) / _BINS * 2 * np.pi - np.pi
_AHEAD = np.stack([np.cos(_AZIMUTH), np.sin(_AZIMUTH)])
_LEFT = np.stack([-np.sin(_AZIMUTH), np.cos(_AZIMUTH)])


def range_profile(xyz: Float32[Array, "n 3"]) -> Float64[Array, " 720"] | None:
    """Mean logarithm of the horizontal range in each half degree of azimuth; None where most of these are empty.

    Gaps are filled from their neighbours.
    """
    x, y = xyz[:, 0].astype(np.float64), xyz[:, 1].astype(np.float64)
    distance = np.hypot(x, y)
    there = distance > _NEAREST_M
    at = ((np.arctan2(y[there], x[there]) / (2 * np.pi) + 0.5) * _BINS).astype(np.int64) % _BINS
    count = np.bincount(at, minlength=_BINS)
    filled = np.flatnonzero(count)
    if filled.size < _BINS // 8:
        return None
    mean = np.bincount(at, np.log(distance[there]), _BINS)[filled] / count[filled]
    profile: Array = np.interp(np.arange(_BINS), filled, mean, period=_BINS)
    return profile


def turn_between(before: Float64[Array, " 720"], after: Float64[Array, " 720"]) -> float:
    r"""How far a sensor turned to the left between two range profiles, in radians; turns beyond 0.8 rad are not found.

    Circular correlation gives the turn to a bin; from there on turn and travel are fitted together by the ranges' flow:
    a sensor that travels by t and turns by w sees at azimuth a, with u pointing there and v to the left of it,

    .. math:: l'(a) = l(a + w + t \cdot v / r) - t \cdot u / r, \quad l = \log r

    Without the travel a wall that comes nearer looks like a turn. What is hidden or comes into view has little weight.
    """
    correlation = np.fft.irfft(np.conj(np.fft.rfft(after - after.mean())) * np.fft.rfft(before - before.mean()), _BINS)
    most = int(_MOST_TURN_RAD / (2 * np.pi) * _BINS)
    lags = np.arange(-most, most + 1)
    turn = float(lags[np.argmax(correlation[lags])]) * 2 * np.pi / _BINS
    travel: Array = np.zeros(2)
    nearness = np.exp(-after)
    for _ in range(_FITS):
        there, slope = _around(before, turn + (travel @ _LEFT) * nearness)
        rest = after - (there - (travel @ _AHEAD) * nearness)
        weight = 1 / (1 + (rest / max(float(np.median(np.abs(rest))), 1e-4)) ** 2)
        columns = np.column_stack([slope, (slope * _LEFT - _AHEAD).T * nearness[:, None]]) * weight[:, None]
        step = np.linalg.lstsq(columns, rest * weight, rcond=1e-3)[0]
        turn, travel = turn + float(step[0]), travel + step[1:]
    return turn


def _around(
    profile: Float64[Array, " 720"], beyond_rad: Array
) -> tuple[Float64[Array, " 720"], Float64[Array, " 720"]]:
    """A profile so far to the left of each of its bins, and its slope there."""
    at = np.arange(_BINS) + beyond_rad * _BINS / (2 * np.pi)
    low = np.floor(at).astype(np.int64)
    first, second = profile[low % _BINS], profile[(low + 1) % _BINS]
    return first + (second - first) * (at - low), (second - first) * _BINS / (2 * np.pi)


def small_grey(rgb: UInt8[Array, "h w 3"]) -> Float32[Array, "120 160"]:
    """A picture as small as its sideways motion needs it."""
    small = cv2.resize(rgb, _PICTURE_PX, interpolation=cv2.INTER_AREA)
    return cv2.cvtColor(small, cv2.COLOR_RGB2GRAY).astype(np.float32)


def shift_between(before: Float32[Array, "120 160"], after: Float32[Array, "120 160"]) -> float:
    """How far a picture moved to the right from one to the next, as a share of its width: a camera that turns left.

    By phase correlation, which places the peak between the pixels.
    """
    window = cv2.createHanningWindow(_PICTURE_PX, cv2.CV_32F)
    (right, _), _ = cv2.phaseCorrelate(before, after, window)
    return float(right) / _PICTURE_PX[0]
