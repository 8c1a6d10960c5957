"""How an odometry's poses say that the robot moved: travel forward and to the left, and turning, as time goes on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, Int64
from numpy.lib.stride_tricks import sliding_window_view

from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import yaw_from_quaternion

POSE_COLUMNS = ("x_m", "y_m", "qx", "qy", "qz", "qw")
_LEAST_POSES = 4
_JUMP_M, _JUMP_RAD = 0.03, 0.06
"""A step that differs by less from those around it is no jump,"""
_NOISES = 8.0
"""nor one that differs by less than so many times the noise of the poses."""
_MOST_MPS2, _MOST_RADPS2 = 5.0, 10.0
"""No robot gains speed faster: at a low rate the first step of a start is long, too."""
_AROUND = 5
_SPEED_NOISE = 0.02
"""Speeds are differences over so long a time that the noise of the poses adds no more, in m/s and rad/s."""
_LONGEST_S = 0.5


@dataclass(frozen=True, slots=True)
class PoseTravel:
    """Travel by the poses since the first one, in the robot's own axes at each moment; steps that jump are taken out.

    Attributes:
        rows: The poses that it is made of: those that are finite and have an attitude.
        time_s: Seconds since the first one, strictly increasing.
        way_m: The way of the poses in the plane of their own frame, from the first one on.
        travel: Forward and to the left in metres, and turned to the left in radians, all together.
        noise: Standard deviation of a single pose: along the way in metres (twice), and of the yaw in radians.
        jumps: After which poses the next one is elsewhere at once.
    """

    rows: Int64[Array, " n"]
    time_s: Float64[Array, " n"]
    way_m: Float64[Array, "n 2"]
    travel: Float64[Array, "n 3"]
    noise: Float64[Array, " 3"]
    jumps: Bool[Array, " steps"]

    @property
    def period_s(self) -> float:
        """The usual time between two poses."""
        return float(np.median(np.diff(self.time_s)))

    def speeds(self) -> Float64[Array, "n 3"]:
        """Speed forward and to the left in m/s and turning rate in rad/s: differences of the poses around each.

        Poses without noise give the differences of neighbours; noisy or unsteady ones are taken further apart, half a
        second at most.
        """
        unsteady_s = float(np.quantile(np.abs(np.diff(self.time_s) - self.period_s), 0.9))
        half_s = np.clip(self.noise / np.sqrt(2) / _SPEED_NOISE, max(self.period_s, 2 * unsteady_s), _LONGEST_S)
        half_s = np.maximum(half_s, self.period_s)
        columns = []
        for travel, half in zip(self.travel.T, half_s.tolist(), strict=True):
            before = np.maximum(self.time_s - half, self.time_s[0])
            after = np.minimum(self.time_s + half, self.time_s[-1])
            moved = np.interp(after, self.time_s, travel) - np.interp(before, self.time_s, travel)
            columns.append(moved / (after - before))
        return np.column_stack(columns)


def pose_travel(odometry: TimedStream) -> PoseTravel | None:
    """How the poses move; None of fewer than four, or where most have no attitude."""
    poses = odometry.columns(*POSE_COLUMNS)
    finite = np.asarray(np.isfinite(poses).all(axis=1))
    usable = finite & (np.linalg.norm(np.where(finite[:, None], poses, 0.0)[:, 2:], axis=1) > 1e-6)
    rows = np.flatnonzero(usable)
    if rows.size < max(_LEAST_POSES, finite.sum() / 2):
        return None
    stamps_ns, poses = odometry.time.stamps_ns[rows], poses[rows]
    time_s = (stamps_ns - stamps_ns[0]) * 1e-9
    yaw_rad = np.unwrap(yaw_from_quaternion(poses[:, 2:]))
    steps = np.column_stack([np.diff(poses[:, :2] - poses[0, :2], axis=0), np.diff(yaw_rad)])
    noise_m, noise_rad = _noise(np.cumsum(steps[:, :2], axis=0)).mean(), _noise(np.cumsum(steps[:, 2:], axis=0)).mean()
    noise = np.array([noise_m, noise_m, noise_rad])
    mended, jumps = _without_jumps(steps, np.diff(time_s), noise)
    way_m, travel = np.zeros((rows.size, 2)), np.zeros((rows.size, 3))
    way_m[1:] = np.cumsum(mended[:, :2], axis=0)
    travel[1:] = np.cumsum(in_body(mended, yaw_rad[:-1] + steps[:, 2] / 2), axis=0)
    return PoseTravel(rows, time_s, way_m, travel, noise, jumps)


def in_body(steps: Float64[Array, "n 3"], yaw_rad: Float64[Array, " n"]) -> Float64[Array, "n 3"]:
    """Steps (x, y, turn) in the axes of a body that looks along a yaw: forward, left, turn."""
    cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)
    forward = steps[:, 0] * cosine + steps[:, 1] * sine
    return np.column_stack([forward, steps[:, 1] * cosine - steps[:, 0] * sine, steps[:, 2]])


def _noise(values: Float64[Array, "n columns"]) -> Float64[Array, " columns"]:
    """Standard deviation of independent noise, by the middle size of second differences."""
    if len(values) < 3:
        return np.zeros(values.shape[1])
    return np.asarray(1.4826 * np.median(np.abs(np.diff(values, 2, axis=0)), axis=0) / np.sqrt(6))


def _without_jumps(
    steps: Float64[Array, "steps 3"], step_s: Float64[Array, " steps"], noise: Float64[Array, " 3"]
) -> tuple[Float64[Array, "steps 3"], Bool[Array, " steps"]]:
    """The steps with those that jump replaced by the middle one of their neighbours, and which ones they are."""
    period_s = float(np.median(step_s))
    around = _median_around(steps / np.maximum(step_s, period_s)[:, None])
    usual = around * step_s[:, None]
    apart = np.column_stack([np.linalg.norm((steps - usual)[:, :2], axis=1), np.abs(steps - usual)[:, 2]])
    # A stamp may be wrong by a whole period.
    paced = np.column_stack([np.linalg.norm(around[:, :2], axis=1), np.abs(around[:, 2])]) * period_s
    gained = np.array([_MOST_MPS2, _MOST_RADPS2]) * np.maximum(step_s, period_s)[:, None] ** 2 * _AROUND / 2
    jumps = (apart > paced + gained + _NOISES * noise[1:] + (_JUMP_M, _JUMP_RAD)).any(axis=1)
    return np.where(jumps[:, None], usual, steps), jumps


def _median_around(values: Float64[Array, "n columns"]) -> Float64[Array, "n columns"]:
    padded = np.pad(values, ((_AROUND // 2, _AROUND // 2), (0, 0)), mode="edge")
    return np.asarray(np.median(sliding_window_view(padded, _AROUND, axis=0), axis=-1))
