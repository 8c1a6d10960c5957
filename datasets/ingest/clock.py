"""Which time of a message counts: the stamp of its header, or when it was recorded."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Int64

OTHER_EPOCH_NS = 1_000_000_000
"""Clocks that are further apart than this count from another origin (simulated time, a clock never set)."""
NO_STAMP = -1


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

    stamps_ns: Int64[np.ndarray, " kept"]
    order: Int64[np.ndarray, " kept"]
    source: str
    backwards: int = 0
    repeated: int = 0
    unstamped: int = 0
    offset_ns: int | None = None
    notes: tuple[str, ...] = field(default=())


def clock_offset(header_ns: Int64[np.ndarray, " n"], record_ns: Int64[np.ndarray, " n"]) -> int | None:
    """Median of header minus record time over the messages with a stamp; None where there is none."""
    stamped = header_ns > 0
    return int(np.median(header_ns[stamped] - record_ns[stamped])) if stamped.any() else None


def stream_time(
    header_ns: Int64[np.ndarray, " n"], record_ns: Int64[np.ndarray, " n"], reference_offset_ns: int | None
) -> StreamTime:
    """Order a stream by its header stamps where they can be used, else by record time.

    Args:
        header_ns: Header stamps; -1 where the type has no header, 0 where it was left empty.
        record_ns: When each message was recorded.
        reference_offset_ns: Header minus record time of the stream that makes the grid; None if it has no headers.
            A stream without usable headers is moved by it where it is beyond one second, so that recordings in
            simulated time keep their streams together.
    """
    offset = clock_offset(header_ns, record_ns)
    stamped = header_ns > 0
    notes: list[str] = []
    shift = reference_offset_ns if reference_offset_ns is not None and abs(reference_offset_ns) > OTHER_EPOCH_NS else 0
    same_epoch = offset is not None and abs(offset - (reference_offset_ns or 0)) <= OTHER_EPOCH_NS
    if same_epoch and stamped.sum() * 2 > stamped.size:
        source, times, usable = "header", header_ns, stamped
    else:
        source, times, usable = "record", record_ns + shift, np.ones(stamped.size, dtype=np.bool_)
        notes.append(_why_record_time(header_ns, offset, reference_offset_ns, shift))
    positions = np.flatnonzero(usable)
    kept = times[positions]
    backwards = int((np.diff(kept) < 0).sum())
    by_time = np.argsort(kept, kind="stable")
    stamps, first = np.unique(kept[by_time], return_index=True)
    if backwards:
        notes.append(f"{backwards} stamps run backwards; sorted by time")
    return StreamTime(
        stamps_ns=stamps,
        order=positions[by_time[first]],
        source=source,
        backwards=backwards,
        repeated=int(kept.size - stamps.size),
        unstamped=int((~usable).sum()),
        offset_ns=offset,
        notes=tuple(notes),
    )


def _why_record_time(
    header_ns: Int64[np.ndarray, " n"], offset_ns: int | None, reference_offset_ns: int | None, shift: int
) -> str:
    moved = f", moved by {shift * 1e-9:+.3f} s onto the clock of the headers" if shift else ""
    if (header_ns == NO_STAMP).all():
        return f"the type has no header: record time{moved}"
    if offset_ns is None or (header_ns > 0).sum() * 2 <= header_ns.size:
        return f"{int((header_ns <= 0).sum())} of {header_ns.size} headers have no stamp: record time{moved}"
    apart = (offset_ns - (reference_offset_ns or 0)) * 1e-9
    return f"the headers' clock is {apart:+.3f} s away from that of the grid's stream: record time{moved}"
