"""Stretches in which an odometry's velocities or its poses stand still while the other goes on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64

from navtool.datasets.streams.pose_travel import PoseTravel
from navtool.datasets.streams.twist_windows import SLOWEST, local_windows, summed
from navtool.pipeline.arrays import Array

_STRETCH_S = 0.5
"""Shorter stretches are none,"""
_PERIODS = 4.0
"""and those of fewer messages, or updates of a sensor that is slower than its messages,"""
_LONG_S = 1.0
"""but for stretches that last so long."""
_MOSTLY = 0.5
_APART = 0.3
"""Velocities and poses differ where the ways are further apart than this share of the longer one,"""
_LEAST = np.array([0.1, 0.1, 0.1])
"""and by more than this: metres forward and left, radians."""
_APART_S = 1.0
"""Rows that are apart for a shorter time are not told of."""


@dataclass(frozen=True, slots=True)
class Rows:
    """Which poses of a travel have velocities that their neighbours belie, by column (forward, left, turn).

    Attributes:
        stale: The velocity stays the same while the poses say another one.
        stopped: The poses stay the same while the velocity says that the robot moves.
        apart: Both live, and say different things.
    """

    stale: Bool[Array, "n 3"]
    stopped: Bool[Array, " n"]
    apart: Bool[Array, "n 3"]


def compare_rows(
    speeds: Float64[Array, "n 3"], poses: Float64[Array, "n columns"], travel: PoseTravel, compared: Bool[Array, " 3"]
) -> Rows:
    """Look at every row.

    Args:
        speeds: Forward, left, turning rate, as far as they could be mended.
        poses: As recorded: what does not change to the last digit stands still.
        travel: By these poses.
        compared: Columns that were measured.
    """
    # What was not measured is not compared.
    speeds = np.where(np.isfinite(speeds), speeds, travel.speeds())
    local = _local_mismatch(speeds, travel.travel, travel, compared)
    columns = np.flatnonzero(compared)
    stopped, stale = np.zeros(len(speeds), dtype=np.bool_), np.zeros_like(local)
    for first, last in _stretches((np.diff(poses, axis=0) == 0).all(axis=1), travel.time_s):
        stopped[first : last + 1] |= _belied(speeds, travel.travel, travel, local, first, last, columns)
    # Where the poses stop they say nothing of the velocities.
    way = _bridged(travel.travel, summed(speeds, travel.time_s), stopped)
    local = _local_mismatch(speeds, way, travel, compared)
    for column in columns:
        for first, last in _stretches(np.diff(speeds[:, column]) == 0, travel.time_s):
            if _belied(speeds, way, travel, local, first, last, np.array([column])):
                stale[first : last + 1, column] = True
                stale[first : last + 1, _stopped_too(speeds, columns, first, last)] = True
    stale[stopped] = False
    apart = local & ~stale & ~_widened(stopped | stale.any(axis=1), travel)[:, None]
    for column in range(3):
        apart[:, column] = _lasting(apart[:, column], travel.time_s)
    return Rows(stale, stopped, apart)


def _stopped_too(
    speeds: Float64[Array, "n 3"], columns: Int64[Array, " columns"], first: int, last: int
) -> Int64[Array, " some"]:
    """The columns that stay the same within a stretch, and mostly change outside it."""
    same = np.diff(speeds[:, columns], axis=0) == 0
    outside = np.concatenate([same[:first], same[last:]])
    lively = outside.mean(axis=0) < _MOSTLY if len(outside) else np.zeros(columns.size, dtype=np.bool_)
    return np.asarray(columns[same[first:last].all(axis=0) & lively])


def _bridged(
    way: Float64[Array, "n 3"], by_twist: Float64[Array, "n 3"], stopped: Bool[Array, " n"]
) -> Float64[Array, "n 3"]:
    """The way of the poses with that of the velocities where the poses stop."""
    if not stopped.any():
        return way
    steps = np.where((stopped[1:] & stopped[:-1])[:, None], np.diff(by_twist, axis=0), np.diff(way, axis=0))
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _local_mismatch(
    speeds: Float64[Array, "n 3"], way: Float64[Array, "n 3"], travel: PoseTravel, compared: Bool[Array, " 3"]
) -> Bool[Array, "n 3"]:
    """Where half a second, or two, around a pose are of another length by the velocities than by the poses."""
    out = np.zeros(speeds.shape, dtype=np.bool_)
    for length_s in (_STRETCH_S, 4 * _STRETCH_S):
        local = local_windows(travel, length_s)
        by_poses, by_twist = local.over(way), local.over(summed(speeds, travel.time_s))
        # Sideways and along belong together: a share of the whole way is meant.
        sizes = np.maximum(np.abs(by_poses), np.abs(by_twist))
        sizes[:, :2] = sizes[:, :2].max(axis=1, keepdims=True)
        least = SLOWEST * (local.length_s[:, None] + _STRETCH_S) + 6 * travel.noise
        out[(local.start + local.end) // 2] |= np.abs(by_poses - by_twist) > _APART * sizes + least
    return out & compared


def _belied(
    speeds: Float64[Array, "n 3"],
    way: Float64[Array, "n 3"],
    travel: PoseTravel,
    local: Bool[Array, "n 3"],
    first: int,
    last: int,
    columns: Int64[Array, " columns"],
) -> bool:
    """Whether a stretch is of another length by its velocities than by its poses, for half a second or as a whole."""
    rows = slice(first, last + 1)
    time_s = travel.time_s[rows]
    inside = (time_s > time_s[0] + _STRETCH_S) & (time_s < time_s[-1] - _STRETCH_S)
    if (local[rows][inside][:, columns].sum(axis=0) * travel.period_s >= _STRETCH_S).any():
        return True
    by_poses, by_twist = (way[rows] - way[first])[:, columns], summed(speeds[rows][:, columns], time_s)
    longest = np.maximum(np.abs(by_poses).max(axis=0), np.abs(by_twist).max(axis=0))
    least = _LEAST[columns] + 0.05 * float(time_s[-1] - time_s[0]) + 6 * travel.noise[columns]
    return bool((np.abs(by_poses - by_twist).max(axis=0) > _APART * longest + least).any())


def _stretches(same: Bool[Array, " steps"], time_s: Float64[Array, " n"]) -> list[tuple[int, int]]:
    """First and last row of the stretches in which nothing changes, that last longer than is usual."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], same.astype(np.int8), [0]])))
    first, last = edges[::2], edges[1::2]
    changes = np.flatnonzero(~same)
    period_s = float(np.median(np.diff(time_s)))
    update_s = float(np.median(np.diff(time_s[changes]))) if changes.size > 2 else period_s
    least_s = max(_STRETCH_S, _PERIODS * period_s, min(_PERIODS * update_s, _LONG_S))
    long = time_s[last] - time_s[first] >= least_s
    return list(zip(first[long].tolist(), last[long].tolist(), strict=True))


def _widened(flags: Bool[Array, " n"], travel: PoseTravel) -> Bool[Array, " n"]:
    """The flags and what lies within half a second of one."""
    at = travel.time_s[flags]
    if not at.size:
        return flags
    place = np.searchsorted(at, travel.time_s).clip(1, max(at.size - 1, 1))
    near = np.minimum(np.abs(travel.time_s - at[place - 1]), np.abs(travel.time_s - at[place.clip(max=at.size - 1)]))
    return np.asarray(near <= _STRETCH_S)


def _lasting(flags: Bool[Array, " n"], time_s: Float64[Array, " n"]) -> Bool[Array, " n"]:
    """The flags of stretches that last for a second."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    kept = np.zeros_like(flags)
    for first, end in zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True):
        kept[first:end] = time_s[end - 1] - time_s[first] >= _APART_S
    return kept
