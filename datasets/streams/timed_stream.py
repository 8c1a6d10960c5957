"""A small stream in the order of time, and the robot's motion by its odometry."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64

from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.motion import Motion
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.pipeline.arrays import Array

_USED = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", "vx_mps", "wz_radps")


@dataclass(frozen=True, slots=True)
class TimedStream:
    """A small stream in the order of time: stamps and values of the same messages."""

    recorded: RecordedStream
    time: StreamTime
    values: Float64[Array, "kept columns"]

    @property
    def present(self) -> Bool[Array, "kept joints"] | None:
        """Which joints each message names; None where all name all."""
        return None if self.recorded.present is None else self.recorded.present[self.time.order]

    @classmethod
    def of(cls, recorded: RecordedStream, time: StreamTime) -> "TimedStream":
        """The stream's rows in the order of their stamps."""
        return cls(recorded, time, recorded.values()[time.order])

    def columns(self, *names: str) -> Float64[Array, "kept names"]:
        """The named columns."""
        return self.values[:, [self.recorded.columns.index(name) for name in names]]


def unit_quaternions(stream: TimedStream) -> Float64[Array, "kept 4"]:
    """The attitudes of an odometry; one that was never set is level."""
    quaternions = stream.columns("qx", "qy", "qz", "qw")
    unset = np.linalg.norm(quaternions, axis=1) < 1e-6
    return np.where(unset[:, None], np.array([0.0, 0.0, 0.0, 1.0]), quaternions)


def measured(odometry: TimedStream) -> Bool[Array, " kept"]:
    """Which messages of an odometry say what the rows are made of: the pose, the speed forward and the turning rate."""
    return np.asarray(np.isfinite(odometry.columns(*_USED)).all(axis=1))


def motion_of(odometry: TimedStream | None, max_gap_s: float) -> Motion | None:
    """The robot's motion by its odometry, where it has one."""
    if odometry is None or not len(odometry.values):
        return None
    finite = measured(odometry)
    position = odometry.columns("x_m", "y_m", "z_m")[finite]
    return Motion(odometry.time.stamps_ns[finite], position, unit_quaternions(odometry)[finite], max_gap_s)
