"""Clock against clock: which stream's header clock is apart from the others', by how much, and what to do about it.

Every stream says when its messages were measured (headers) and when they were recorded. Between the two lies the
latency of its sensor, which differs by sensor and is never negative. What lies outside of that is a clock that is
apart: ahead of the recorder, or further behind than its sensor can be late.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int64

from navtool.base.note import Note
from navtool.datasets.streams.table import in_order, row_of
from navtool.pipeline.arrays import Array

SUSPECTED = "clock.offset-suspected"
"""Code of the notes that say that a clock may be off, and that nothing was done."""

OFFSET = "clock.offset"
"""Code of the notes that say by how much a header clock is off, and what was done."""

AHEAD_S = 0.1
"""Further ahead of the recorder no stamp of the same clock can be."""
SUSPECT_S = 0.1
"""A stream that is later than the others by more than this may be late, or its clock may be behind."""
_LEAST_MESSAGES = 8
_WINDOWS = 20
_WANDER_S = 0.1
"""A clock that strays further from a straight line against the recorder's has no one offset."""
_DRIFT_S = 0.02
"""A drift over the whole recording that is worth taking out with an offset."""
_JITTER_SHARE = 0.25
"""Where stamps are that unsteady against how late they are it is a queue that is late, not a clock that is behind."""
_KNOWN_S = {
    "between TAI and UTC": (37.0, 36.0, 35.0),
    "between GPS time and UTC": (18.0, 17.0, 16.0),
    "between TAI and GPS time": (19.0,),
    "a time zone": tuple(900.0 * quarter for quarter in range(1, 57)),
}
"""Differences between clocks that are exact, in seconds."""


class OffsetPolicy(StrEnum):
    """What becomes of a stream whose header clock is apart from the others'."""

    correct = "correct"
    """Its stamps are shifted onto the others' clock, with a note."""
    refuse = "refuse"
    """The recording is refused."""
    keep = "keep"
    """Its stamps stay, with a note."""


@dataclass(frozen=True, slots=True)
class Shift:
    """What is added to a stream's stamps: straight over the time of record."""

    seconds: float
    """At the middle of the recording."""
    drift: float = 0.0
    """Seconds a second of record time."""
    middle_ns: int = 0
    exact: bool = False
    """Whether it is a known difference between two clocks, or one that was set."""

    def of(self, record_ns: Int64[Array, " n"]) -> Int64[Array, " n"]:
        """What to add to the stamps of messages that were recorded at these times."""
        added: Array = np.rint((self.seconds + self.drift * (record_ns - self.middle_ns) * 1e-9) * 1e9).astype(np.int64)
        return added


@dataclass(frozen=True, slots=True)
class ClockOffset:
    """A stream's header clock against the others'."""

    apart_s: float
    """How far its stamps are ahead of where the others' clock would have them; negative is behind."""
    shift: Shift | None
    """What was added to its stamps; None where they stay."""
    note: Note | None = None


@dataclass(frozen=True)
class Latency:
    """A stream's stamps against their times of record.

    Attributes:
        apart_s: Header minus record, of each stamped message.
        record_ns: When these were recorded.
        limit_s: How late the least delayed message of such a sensor can be.
    """

    apart_s: Float64[Array, " n"]
    record_ns: Int64[Array, " n"]
    limit_s: float

    @cached_property
    def least_s(self) -> float:
        """Header minus record of the least delayed messages: negative where they are late."""
        return float(np.quantile(self.apart_s, 0.95))

    @cached_property
    def _windows(self) -> tuple[Float64[Array, " k"], Float64[Array, " k"], float]:
        """Middles of windows in seconds from that of the recording, their least delayed, and the jitter within."""
        parts = np.array_split(np.arange(self.apart_s.size), min(_WINDOWS, self.apart_s.size // 4))
        since_s = (self.record_ns - self.middle_ns) * 1e-9
        least = np.array([np.quantile(self.apart_s[part], 0.9) for part in parts])
        jitter = float(
            np.median([np.quantile(self.apart_s[part], 0.9) - np.median(self.apart_s[part]) for part in parts])
        )
        return np.array([since_s[part].mean() for part in parts]), least, jitter

    @property
    def middle_ns(self) -> int:
        """The middle of the time of record."""
        return int(self.record_ns[0] + (self.record_ns[-1] - self.record_ns[0]) // 2)

    @property
    def jitter_s(self) -> float:
        """How far a usual message is behind the least delayed ones around it."""
        return self._windows[2]

    @cached_property
    def line(self) -> tuple[float, float] | None:
        """Least delayed against time of record: its value in the middle, and its slope; None where it is no line."""
        at, least, _ = self._windows
        slope = 0.0
        if at.size > 2 and np.ptp(at) > 0:
            slope = float(np.polyfit(at, least, 1)[0])
        if abs(slope) * np.ptp(at) < _DRIFT_S:
            slope = 0.0
        rest = least - slope * at
        return None if np.quantile(rest, 0.9) - np.quantile(rest, 0.1) > _WANDER_S else (float(np.median(rest)), slope)

    def fits(self, level_s: float) -> bool:
        """Whether a clock that is so far from the recorder's explains the stamps by a latency."""
        return -self.limit_s <= self.least_s - level_s <= AHEAD_S


def latency_of(stream: str, header_ns: Int64[Array, " n"], record_ns: Int64[Array, " n"]) -> Latency | None:
    """A stream's stamps against their times of record; None where too few have a stamp."""
    stamped = header_ns > 0
    if stamped.sum() < _LEAST_MESSAGES or stamped.sum() * 2 <= stamped.size:
        return None
    apart_s = (header_ns[stamped] - record_ns[stamped]) * 1e-9
    return Latency(apart_s, record_ns[stamped], row_of(stream).late_s)


@dataclass(frozen=True, slots=True)
class Comparison:
    """The clocks of a recording's streams, compared.

    Attributes:
        level_s: How far the clock that most streams share is from the recorder's; 0 where some share the recorder's.
        agreeing: Streams that share it.
        offsets: Those whose clock is apart, or may be.
    """

    level_s: float
    agreeing: tuple[str, ...]
    offsets: Mapping[str, ClockOffset]


def compare_clocks(latencies: Mapping[str, Latency], given: Collection[str] = ()) -> Comparison:
    """Which streams' header clocks are apart from the others'.

    Args:
        latencies: By stream.
        given: Streams whose offset is set by hand: they are left as they are.
    """
    level_s, agreeing = _shared(latencies)
    offsets = {}
    if agreeing:
        usual_s = float(np.median([latencies[name].least_s for name in agreeing]))
        for name, latency in latencies.items():
            if name not in given:
                others = [latencies[other].least_s for other in agreeing if other != name]
                found = _offset(latency, usual_s, others, fits=name in agreeing)
                if found is not None:
                    offsets[name] = found
    return Comparison(level_s, tuple(agreeing), _together(latencies, offsets))


def _shared(latencies: Mapping[str, Latency]) -> tuple[float, list[str]]:
    """How far from the recorder's the clock lies that streams share, and which do: the recorder's before any other."""
    by_record = [name for name in in_order(latencies) if latencies[name].fits(0.0)]
    if any(row_of(name).makes_grid or row_of(name).never_still for name in by_record):
        return 0.0, by_record
    groups = [
        (latency.least_s, [name for name in in_order(latencies) if latencies[name].fits(latency.least_s)])
        for latency in (latencies[name] for name in in_order(latencies))
    ]
    return max(groups, key=lambda group: len(group[1]), default=(0.0, []))


def _offset(latency: Latency, usual_s: float, others_s: list[float], *, fits: bool) -> ClockOffset | None:
    apart_s = latency.least_s - usual_s
    if fits:
        behind_s = max(others_s, default=latency.least_s) - latency.least_s
        return ClockOffset(-behind_s, None, _suspicion(behind_s)) if behind_s > SUSPECT_S else None
    line = latency.line
    if line is None or (apart_s < 0 and latency.jitter_s > _JITTER_SHARE * -apart_s):
        return ClockOffset(apart_s, None, _suspicion(-apart_s))
    at_middle_s, drift = line
    apart_s = at_middle_s - usual_s
    known = None if drift else _known(apart_s)
    if known is None:
        return ClockOffset(apart_s, Shift(-apart_s, -drift, latency.middle_ns))
    what, exact_s = known
    return ClockOffset(exact_s, Shift(-exact_s, exact=True), _exact(what, exact_s))


def _together(latencies: Mapping[str, Latency], offsets: Mapping[str, ClockOffset]) -> dict[str, ClockOffset]:
    """The offsets, those of streams that share a clock made one: what they had between them stays."""
    shared = dict(offsets)
    open_ = [name for name in in_order(offsets) if offsets[name].shift is not None and offsets[name].note is None]
    while open_:
        first = open_[0]
        near = [name for name in open_ if abs(offsets[name].apart_s - offsets[first].apart_s) <= AHEAD_S]
        open_ = [name for name in open_ if name not in near]
        shifts = {name: shift for name in near if (shift := offsets[name].shift) is not None}
        lead = shifts[max(near, key=lambda name: latencies[name].apart_s.size)]
        steady = all(not shift.drift for shift in shifts.values())
        seconds = float(np.median([shift.seconds for shift in shifts.values()])) if steady else lead.seconds
        for name in near:
            shift = Shift(seconds, lead.drift, lead.middle_ns)
            shared[name] = ClockOffset(-seconds, shift, _estimate(-seconds, lead.drift))
    return shared


def _known(apart_s: float) -> tuple[str, float] | None:
    for what, sizes in _KNOWN_S.items():
        for size in sizes:
            # The others' usual latency is taken off already; what is left is the difference of two latencies.
            if abs(abs(apart_s) - size) < AHEAD_S:
                return what, float(np.copysign(size, apart_s))
    return None


def _exact(what: str, exact_s: float) -> Note:
    text = f"its header clock is {_side(exact_s)} the others', as it is {what}; its stamps were shifted"
    return Note(OFFSET, text)


def _estimate(apart_s: float, drift: float) -> Note:
    drifts = f", and drifts by {drift * -1e6:+.0f} ppm" if drift else ""
    text = f"its header clock is {_side(apart_s)} the others' by the times of record{drifts}; its stamps were shifted"
    return Note(OFFSET, text)


def _suspicion(behind_s: float) -> Note:
    text = (
        f"its stamps are {_side(-behind_s)} the others' against the times of record: a sensor that is late, or a clock "
        "that is apart; they stay as they are"
    )
    return Note(SUSPECTED, text)


def _side(apart_s: float) -> str:
    return f"{abs(apart_s):.3f} s {'ahead of' if apart_s > 0 else 'behind'}"
