"""Portions of a recording with one outcome, and how they become labels of rows."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int64, Shaped

from navtool.pipeline.arrays import Array

SUCCESS = 1
FAILURE = 0


@dataclass(frozen=True, slots=True)
class LabelInterval:
    """A portion [start_ns, end_ns) on the data set's clock; an instant where both are equal."""

    start_ns: int
    end_ns: int
    outcome: int
    reason: str
    confidence: float


class RowLabels(NamedTuple):
    """Labels of an episode's rows."""

    outcome: Int64[Array, " rows"]
    reason: Shaped[Array, " rows"]
    """Text; empty where nothing is known but that the run went on."""
    confidence: Float32[Array, " rows"]


def label_rows(
    stamps_ns: Int64[Array, " rows"],
    period_ns: int,
    intervals: Sequence[LabelInterval],
    default_confidence: float,
) -> RowLabels:
    """Each row's label: success by default, else that of the last interval in the sequence that covers the row.

    A row is covered when its stamp lies in the interval. An interval too short to hold any stamp covers the nearest
    row within half a period, so that no event is lost between two rows.
    """
    outcome = np.full(stamps_ns.size, SUCCESS, dtype=np.int64)
    reason = np.full(stamps_ns.size, "", dtype=np.object_)
    confidence = np.full(stamps_ns.size, default_confidence, dtype=np.float32)
    for interval in intervals:
        rows = covered_rows(stamps_ns, period_ns, interval.start_ns, interval.end_ns)
        outcome[rows], reason[rows], confidence[rows] = interval.outcome, interval.reason, interval.confidence
    return RowLabels(outcome, reason, confidence)


def covered_rows(stamps_ns: Int64[Array, " rows"], period_ns: int, start_ns: int, end_ns: int) -> slice:
    """The rows of the interval; empty where it lies outside the episode. Stamps must increase."""
    first, stop = np.searchsorted(stamps_ns, [start_ns, end_ns])
    if first < stop or stamps_ns.size == 0:
        return slice(int(first), int(stop))
    around = np.array([max(first - 1, 0), min(first, stamps_ns.size - 1)])
    # An instant has no inside: it belongs to the row whose half period it falls into.
    distance = np.abs(stamps_ns[around] - (start_ns + end_ns) // 2)
    nearest = int(around[distance.argmin()])
    return slice(nearest, nearest + 1) if 2 * int(distance.min()) <= period_ns else slice(0, 0)


def runs(flags: Bool[Array, " rows"]) -> list[tuple[int, int]]:
    """The maximal runs of true values as (first, stop)."""
    edges = np.diff(np.concatenate(([0], flags.astype(np.int8), [0])))
    return list(zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True))
