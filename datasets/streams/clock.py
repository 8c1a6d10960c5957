"""Which time of a message counts: the stamp of its header, or when it was recorded."""

from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from jaxtyping import Bool, Int64
from numpy.lib.stride_tricks import sliding_window_view

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.pipeline.arrays import Array

OTHER_EPOCH_NS = 1_000_000_000
"""Clocks that are further apart than this count from another origin (simulated time, a clock never set)."""
NO_STAMP = -1
_LEAST = 0.95
"""So many of a stream's messages are more delayed than those that count as least delayed."""


class Clock(StrEnum):
    """Which time of a stream's messages counts."""

    auto = "auto"
    """The header's stamp where it can be used, else the time of record; the sync report says which and why."""
    header = "header"
    """The header's stamp, whatever it says."""
    record = "record"
    """The time of record."""


@dataclass(frozen=True, slots=True)
class Jump:
    """A step of a stream's header clock: its messages were recorded at their pace, but their stamps leapt."""

    position: int
    """The first message behind the step, in the order of record."""
    by_ns: int
    """How far the stamps leapt beyond the pace of record; negative is backwards."""


def mend_jumps(
    header_ns: Int64[Array, " n"], record_ns: Int64[Array, " n"], step_ns: int
) -> tuple[Int64[Array, " n"], tuple[Jump, ...]]:
    """The header stamps without the steps of their clock.

    A step is where two messages were recorded at the stream's usual pace but their stamps are further apart, or further
    back, than that by more than `step_ns`. Behind it the stamps go on at the pace of record. A pause of the stream
    moves both clocks and is none; messages that the recorder wrote late, all at once, are none either.

    Args:
        header_ns: In the order of record; -1 without header, 0 where it was left empty.
        record_ns: When each message was recorded.
        step_ns: The least step that is taken out.
    """
    stamped = np.flatnonzero(header_ns > 0)
    if stamped.size < 3:
        return header_ns, ()
    header_step, record_step = np.diff(header_ns[stamped]), np.diff(record_ns[stamped])
    usual = np.median(record_step)
    leapt = np.abs(header_step - np.median(header_step)) > step_ns
    around = np.median(sliding_window_view(np.pad(record_step, 2, mode="edge"), 5), axis=1)
    paced = (np.abs(record_step - usual) < step_ns / 2) & (around > usual / 2) & (around < usual * 2)
    steps = leapt & paced & (np.abs(header_step - record_step) > step_ns)
    if not steps.any():
        return header_ns, ()
    surplus = np.where(steps, header_step - record_step, 0)
    mended = header_ns.copy()
    mended[stamped[1:]] -= np.cumsum(surplus)
    return mended, tuple(Jump(int(stamped[i + 1]), int(surplus[i])) for i in np.flatnonzero(steps))


@dataclass(frozen=True, slots=True)
class StreamTime:
    """A stream's messages in the order of time.

    Attributes:
        stamps_ns: Strictly increasing times of the kept messages.
        order: Position, in the order of record, of the message behind each stamp.
        source: ``header`` or ``record``.
        backwards: Messages whose stamp was older than that of the one recorded before.
        repeated: Messages dropped because another one has the same stamp.
        unstamped: Messages dropped for a zero stamp in a stream whose other headers have one.
        offset_ns: Median of header minus record time; None without headers.
        notes: What a user should know about this stream's time.
    """

    stamps_ns: Int64[Array, " kept"]
    order: Int64[Array, " kept"]
    source: str
    backwards: int = 0
    repeated: int = 0
    unstamped: int = 0
    offset_ns: int | None = None
    notes: tuple[Note, ...] = field(default=())

    def from_position(self, first: int) -> "StreamTime":
        """Without the messages that were recorded before the one at a position."""
        kept = self.order >= first
        return replace(self, stamps_ns=self.stamps_ns[kept], order=self.order[kept]) if first else self


@dataclass(frozen=True, slots=True)
class ReferenceClock:
    """The header stamps of the stream that makes the grid, against the times at which they were recorded."""

    record_ns: Int64[Array, " n"]
    """Strictly increasing."""
    header_ns: Int64[Array, " n"]
    least_ns: int
    """Header minus record time of the least delayed messages."""
    apart_ns: int = OTHER_EPOCH_NS
    """Beyond this it is another clock than the recorder's."""

    @property
    def other_epoch(self) -> bool:
        """Whether the headers count from another origin than the recorder."""
        return abs(self.least_ns) > self.apart_ns

    def from_record(self, record_ns: Int64[Array, " m"]) -> Int64[Array, " m"]:
        """Times of record on the headers' clock: as they are, or interpolated where the headers' epoch is another.

        A simulated second need not last a second: between the reference's messages the two clocks are joined by
        straight lines, beyond them by the nearest message's difference.
        """
        if not self.other_epoch:
            return record_ns
        first = self.record_ns[0]  # float64 holds nanoseconds since the epoch to 256 only
        moved = np.interp(
            (record_ns - first).astype(np.float64),
            (self.record_ns - first).astype(np.float64),
            (self.header_ns - self.header_ns[0]).astype(np.float64),
        )
        inside = np.clip(record_ns, self.record_ns[0], self.record_ns[-1])
        times: Array = self.header_ns[0] + np.rint(moved).astype(np.int64) + (record_ns - inside)
        return times


def clock_offset(header_ns: Int64[Array, " n"], record_ns: Int64[Array, " n"], share: float = 0.5) -> int | None:
    """Median of header minus record time over the messages with a stamp; None where there is none.

    Args:
        share: Another quantile than the median: 0.95 is that of the messages that were least delayed.
    """
    stamped = header_ns > 0
    if not stamped.any():
        return None
    apart_ns = header_ns[stamped] - record_ns[stamped]
    # Doubles hold differences of years to a quarter of a microsecond only.
    middle_ns = int(np.median(apart_ns))
    return middle_ns if share == 0.5 else middle_ns + int(np.quantile(apart_ns - middle_ns, share))


def reference_clock(
    header_ns: Int64[Array, " n"], record_ns: Int64[Array, " n"], apart_ns: int = OTHER_EPOCH_NS
) -> ReferenceClock | None:
    """The clock that a stream's headers show; None where it has no stamps.

    Args:
        apart_ns: Headers that are further from the times of record are of another clock.
    """
    least_ns = clock_offset(header_ns, record_ns, _LEAST)
    if least_ns is None:
        return None
    stamped = header_ns > 0
    recorded, first = np.unique(record_ns[stamped], return_index=True)
    return ReferenceClock(recorded, header_ns[stamped][first], least_ns, apart_ns)


def stream_time(
    header_ns: Int64[Array, " n"],
    record_ns: Int64[Array, " n"],
    reference: ReferenceClock | None,
    clock: Clock = Clock.auto,
    kept: Bool[Array, " n"] | None = None,
) -> StreamTime:
    """Order a stream by its header stamps where they can be used, else by record time.

    Args:
        header_ns: Header stamps; -1 where the type has no header, 0 where it was left empty.
        record_ns: When each message was recorded.
        reference: Clock of the stream that makes the grid; None if it has no headers. A stream without usable headers
            is moved onto it where it counts from another origin, so that recordings in simulated time keep their
            streams together.
        clock: Which of the two is wanted.
        kept: Which messages count; None for all.

    Raises:
        DatasetsError: Header stamps are wanted and there are none.
    """
    taken: Array = np.ones(header_ns.size, dtype=np.bool_) if kept is None else kept
    least_ns = clock_offset(header_ns[taken], record_ns[taken], _LEAST)
    stamped = taken & (header_ns > 0)
    notes: list[Note] = []
    away_ns = None if least_ns is None else least_ns - (0 if reference is None else reference.least_ns)
    if clock is Clock.header and not stamped.any():
        raise DatasetsError(
            "no message has a header stamp, which the settings ask for", cure="set its clock to auto or record"
        )
    fits = away_ns is not None and abs(away_ns) <= OTHER_EPOCH_NS and stamped.sum() * 2 > taken.sum()
    if clock is Clock.header or (clock is Clock.auto and fits):
        source, times, usable = "header", header_ns, stamped
    else:
        source, usable = "record", taken
        times = record_ns if reference is None else reference.from_record(record_ns)
        moved = reference is not None and reference.other_epoch
        why = "record time, as set" if clock is Clock.record else _why_record_time(header_ns[taken], away_ns)
        why += ", moved onto the clock of the headers" if moved else ""
        notes.append(Note("clock.record-time", why))
    positions = np.flatnonzero(usable)
    kept = times[positions]
    backwards = int((np.diff(kept) < 0).sum())
    by_time = np.argsort(kept, kind="stable")
    stamps, first = np.unique(kept[by_time], return_index=True)
    if backwards:
        notes.append(Note("clock.backwards", f"{backwards} stamps run backwards; sorted by time"))
    return StreamTime(
        stamps_ns=stamps,
        order=positions[by_time[first]],
        source=source,
        backwards=backwards,
        repeated=int(kept.size - stamps.size),
        unstamped=int((taken & ~usable).sum()),
        offset_ns=clock_offset(header_ns[taken], record_ns[taken]),
        notes=tuple(notes),
    )


def _why_record_time(header_ns: Int64[Array, " n"], away_ns: int | None) -> str:
    if (header_ns == NO_STAMP).all():
        return "the type has no header: record time"
    if away_ns is None or (header_ns > 0).sum() * 2 <= header_ns.size:
        return f"{int((header_ns <= 0).sum())} of {header_ns.size} headers have no stamp: record time"
    return f"the headers' clock is {away_ns * 1e-9:+.3f} s away from that of the grid's stream: record time"
