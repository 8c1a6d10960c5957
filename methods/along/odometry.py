"""Odometry as what ticks: for methods that need no other sensor."""

from collections.abc import Iterator
from functools import partial
from typing import ClassVar, NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.methods.along.observation import Reading, Skip, Ticks
from navtool.methods.along.streams import Streams
from navtool.pipeline.arrays import Array


class OdometryReading(NamedTuple):
    """One pose and velocity of the base frame."""

    position_m: Float64[Array, "3"]
    """In the odometry frame."""
    attitude: Float64[Array, "4"]
    """Quaternion (x, y, z, w); all zeros where it was never set."""
    linear_mps: Float64[Array, "3"]
    """In the base frame's axes; zeros where the odometry measures poses alone."""
    angular_radps: Float64[Array, "3"]
    """In the base frame's axes."""


class Odometry(Ticks[OdometryReading]):
    """Each message of the odometry, in the base frame."""

    reads: ClassVar[tuple[str, ...]] = ("odometry",)
    noun: ClassVar[str] = "poses"

    def count(self, streams: Streams) -> int:
        """How many messages there are."""
        return 0 if streams.odometry is None else len(streams.odometry.stamps_ns)

    def duration_s(self, streams: Streams) -> float:
        """The time from the first to the last."""
        return 0.0 if streams.odometry is None else float(np.ptp(streams.odometry.stamps_ns)) * 1e-9

    def readings(self, streams: Streams) -> Iterator[Reading[OdometryReading]]:
        """The messages in the order of their stamps."""
        if streams.odometry is not None:
            for stamp_ns, row in zip(streams.odometry.stamps_ns.tolist(), streams.odometry.values, strict=True):
                yield Reading(stamp_ns, partial(_reading, row))


def _reading(row: Float64[Array, "13"]) -> OdometryReading | Skip:
    if not np.isfinite(row).all():
        return Skip("not finite")
    return OdometryReading(row[:3], row[3:7], row[7:10], row[10:])
