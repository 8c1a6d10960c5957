"""Bringing streams of different rates onto one fixed grid of ticks. Pure: stamps in, indices and errors out."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from jaxtyping import Bool, Float, Float64, Int64

from navtool.pipeline.arrays import Array


class Method(StrEnum):
    """How samples become the value at a tick."""

    nearest = "nearest"
    """The nearest sample, before or after the tick."""
    hold = "hold"
    """The newest sample at or before the tick: nothing of the future."""
    linear = "linear"
    """In proportion between the samples before and after the tick."""


@dataclass(frozen=True, slots=True)
class Match:
    """Which sample serves each tick.

    Attributes:
        index: Index of the chosen sample, -1 where no sample lies within the tolerance.
        error_s: Sample stamp minus tick in seconds (negative: the sample is older); 0 where there is none.
        valid: Whether a sample was found.
    """

    index: Int64[Array, " ticks"]
    error_s: Float64[Array, " ticks"]
    valid: Bool[Array, " ticks"]


def grid_ticks(start_ns: int, end_ns: int, fps: int) -> Int64[Array, " ticks"]:
    """The ticks of the grid: ``start_ns + round(k * 1e9 / fps)`` up to and including ``end_ns``.

    Rounded from the start each time, so the spacing does not drift whatever the rate.
    """
    count = (end_ns - start_ns) * fps // 1_000_000_000 + 1
    return start_ns + (np.arange(count, dtype=np.int64) * 1_000_000_000 + fps // 2) // fps


def nearest(stamps_ns: Int64[Array, " samples"], ticks_ns: Int64[Array, " ticks"], tolerance_s: float) -> Match:
    """The nearest sample to each tick, the earlier one at a tie. Stamps must not decrease."""
    if stamps_ns.size == 0:
        return _none(ticks_ns.size)
    after = np.searchsorted(stamps_ns, ticks_ns).clip(max=stamps_ns.size - 1)
    before = (after - 1).clip(min=0)
    closer_before = np.abs(ticks_ns - stamps_ns[before]) <= np.abs(stamps_ns[after] - ticks_ns)
    return _within(np.where(closer_before, before, after), stamps_ns, ticks_ns, tolerance_s)


def hold(stamps_ns: Int64[Array, " samples"], ticks_ns: Int64[Array, " ticks"], tolerance_s: float) -> Match:
    """The newest sample at or before each tick, if it is no older than the tolerance. Stamps must not decrease."""
    if stamps_ns.size == 0:
        return _none(ticks_ns.size)
    index = np.searchsorted(stamps_ns, ticks_ns, side="right") - 1
    match = _within(index.clip(min=0), stamps_ns, ticks_ns, tolerance_s)
    too_early = index < 0
    return Match(
        index=np.where(too_early, -1, match.index),
        error_s=np.where(too_early, 0.0, match.error_s),
        valid=match.valid & ~too_early,
    )


@dataclass(frozen=True, slots=True)
class Brackets:
    """The two samples around each tick, for interpolation.

    Attributes:
        before: Index of the sample at or before the tick.
        after: Index of the sample at or after it; the same as ``before`` where the tick falls on a sample.
        weight: Share of ``after`` in [0, 1].
        error_s: Stamp of the nearer of the two minus the tick, in seconds.
        valid: Whether the tick lies between two samples that are no further apart than allowed.
    """

    before: Int64[Array, " ticks"]
    after: Int64[Array, " ticks"]
    weight: Float64[Array, " ticks"]
    error_s: Float64[Array, " ticks"]
    valid: Bool[Array, " ticks"]

    def linear(self, values: Float[Array, " samples *shape"]) -> Float64[Array, " ticks *shape"]:
        """Values interpolated linearly; 0 where invalid."""
        weight = self.weight.reshape(-1, *[1] * (values.ndim - 1))
        mixed = values[self.before] * (1.0 - weight) + values[self.after] * weight
        return np.where(self.valid.reshape(weight.shape), mixed, 0.0)


def brackets(stamps_ns: Int64[Array, " samples"], ticks_ns: Int64[Array, " ticks"], max_gap_s: float) -> Brackets:
    """The samples to interpolate between at each tick. Stamps must strictly increase."""
    if stamps_ns.size == 0:
        none = _none(ticks_ns.size)
        zeros = np.zeros(ticks_ns.size, dtype=np.int64)
        return Brackets(zeros, zeros, none.error_s, none.error_s, none.valid)
    after = np.searchsorted(stamps_ns, ticks_ns).clip(max=stamps_ns.size - 1)
    exact = stamps_ns[after] == ticks_ns
    before = np.where(exact, after, (after - 1).clip(min=0))
    span = stamps_ns[after] - stamps_ns[before]
    weight = np.where(span > 0, (ticks_ns - stamps_ns[before]) / np.maximum(span, 1), 0.0)
    inside = (ticks_ns >= stamps_ns[0]) & (ticks_ns <= stamps_ns[-1])
    valid = inside & (span <= round(max_gap_s * 1e9))
    to_before, to_after = stamps_ns[before] - ticks_ns, stamps_ns[after] - ticks_ns
    nearer = np.where(np.abs(to_before) <= np.abs(to_after), to_before, to_after)
    return Brackets(before, after, weight.clip(0.0, 1.0), np.where(valid, nearer * 1e-9, 0.0), valid)


def choose(
    method: Method, stamps_ns: Int64[Array, " samples"], ticks_ns: Int64[Array, " ticks"], tolerance_s: float
) -> Match:
    """One sample a tick, by ``nearest`` or ``hold``.

    Raises:
        ValueError: For ``linear``, which takes two.
    """
    if method is Method.linear:
        raise ValueError("linear takes two samples a tick")
    return (nearest if method is Method.nearest else hold)(stamps_ns, ticks_ns, tolerance_s)


def around_ticks(
    method: Method, stamps_ns: Int64[Array, " samples"], ticks_ns: Int64[Array, " ticks"], tolerance_s: float
) -> Brackets:
    """The samples that make the value at each tick, by any method: a chosen one is both of them."""
    if method is Method.linear or stamps_ns.size == 0:
        return brackets(stamps_ns, ticks_ns, tolerance_s)
    match = choose(method, stamps_ns, ticks_ns, tolerance_s)
    index = match.index.clip(min=0)
    return Brackets(index, index, np.zeros(ticks_ns.size), match.error_s, match.valid)


def _within(
    index: Int64[Array, " ticks"],
    stamps_ns: Int64[Array, " samples"],
    ticks_ns: Int64[Array, " ticks"],
    tolerance_s: float,
) -> Match:
    error_ns = stamps_ns[index] - ticks_ns
    valid = np.abs(error_ns) <= round(tolerance_s * 1e9)
    return Match(np.where(valid, index, -1), np.where(valid, error_ns * 1e-9, 0.0), valid)


def _none(ticks: int) -> Match:
    return Match(np.full(ticks, -1, dtype=np.int64), np.zeros(ticks), np.zeros(ticks, dtype=np.bool_))
