"""What chunked formats share: messages in the order of time out of chunks that overlap in it, damaged ones skipped."""

import heapq
from collections.abc import Callable, Container, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import pairwise
from operator import attrgetter, itemgetter
from types import TracebackType
from typing import NamedTuple

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.foreign import describe

MOST_BYTES = 1 << 30
"""No recorder writes chunks of more than a gibibyte: a longer one is damage, and is not decompressed."""
_MOST_AHEAD_BYTES = 1 << 24
"""Packed chunks above this are not read before their time: two of them at once would take much memory."""


class Chunk(NamedTuple):
    """A portion of the file whose messages are read at once."""

    offset: int
    """Where it begins in the file."""
    size: int
    """Bytes in the file."""
    start_ns: int
    """Record time of its earliest message."""
    end_ns: int
    """Record time of its latest message."""
    channels: frozenset[int]
    """Whose messages it may hold; empty where that is not known."""
    packed: bool = False
    """Whether it is compressed."""


class ChunkMessage(NamedTuple):
    """A message as the chunk holds it."""

    record_ns: int
    channel: int
    data: bytes


type Contents = tuple[bytes, list[tuple[int, int, int, int]], str]
"""A chunk's bytes; for each message its record time, start, end and channel; what its end lacks, empty for nothing."""
type Load = Callable[[Chunk, Container[int]], Contents]


class Skipped:
    """The chunks that could not be read, each counted once however often it is tried."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._reasons: dict[int, str] = {}
        self._bytes = 0
        self._torn: dict[int, str] = {}

    def add(self, chunk: Chunk, error: Exception) -> None:
        """Note a chunk and why it was skipped."""
        if chunk.offset not in self._reasons:
            self._reasons[chunk.offset] = error.what if isinstance(error, DatasetsError) else describe(error)
            self._bytes += chunk.size

    def add_torn(self, chunk: Chunk, what: str) -> None:
        """Note a chunk of which only the beginning can be read."""
        self._torn.setdefault(chunk.offset, what)

    def faults(self) -> tuple[str, ...]:
        """A sentence on the chunks that were skipped, and one on those that were read in part."""
        lines = []
        if self._reasons:
            first = min(self._reasons)
            which = f"the first at byte {first}: {self._reasons[first]}"
            lines.append(f"{len(self._reasons)} of {self._total} chunks skipped, {self._bytes / 1e6:.3f} MB ({which})")
        if self._torn:
            first = min(self._torn)
            which = f"the first at byte {first}: {self._torn[first]}"
            lines.append(f"{len(self._torn)} of {self._total} chunks read in part ({which})")
        return tuple(lines)


def merged(
    chunks: Sequence[Chunk],
    wanted: Container[int],
    load: Load,
    skipped: Skipped,
    start_ns: int,
    end_ns: int,
) -> Iterator[ChunkMessage]:
    """The messages of the wanted channels within the times, by time; a chunk is read when its time comes.

    A compressed one is decompressed a little earlier, in a thread beside, which needs no interpreter for it.
    """
    needed = [
        chunk
        for chunk in chunks
        if chunk.end_ns >= start_ns
        and chunk.start_ns <= end_ns
        and (not chunk.channels or any(channel in wanted for channel in chunk.channels))
    ]
    groups = list(_overlapping(needed))
    with _Ahead(load, [chunk for group in groups for chunk in group]) as ahead:
        for group in groups:
            streams = [_from(chunk, wanted, ahead.load, skipped, start_ns, end_ns) for chunk in group]
            for _, message in streams[0] if len(streams) == 1 else heapq.merge(*streams, key=itemgetter(0)):
                if message is not None:
                    yield message


class _Ahead:
    """Loads each chunk, and with it begins to load the one that comes next where that is compressed."""

    def __init__(self, load: Load, chunks: Sequence[Chunk]) -> None:
        """Load them in this order."""
        self._load = load
        self._next = {chunk.offset: following for chunk, following in pairwise(chunks)}
        self._begun: dict[int, Future[Contents]] = {}
        self._thread = ThreadPoolExecutor(1)

    def load(self, chunk: Chunk, wanted: Container[int]) -> Contents:
        """The contents of a chunk, or whatever error reading it raised."""
        begun = self._begun.pop(chunk.offset, None)
        try:
            return self._load(chunk, wanted) if begun is None else begun.result()
        finally:
            following = self._next.get(chunk.offset)
            if following is not None and following.packed and following.size <= _MOST_AHEAD_BYTES:
                self._begun[following.offset] = self._thread.submit(self._load, following, wanted)

    def __enter__(self) -> "_Ahead":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._thread.shutdown(cancel_futures=True)


def _overlapping(chunks: Sequence[Chunk]) -> Iterator[list[Chunk]]:
    """Chunks whose times overlap together, in the order of time: most recorders write one chunk after the other."""
    group: list[Chunk] = []
    end_ns = 0
    for chunk in sorted(chunks, key=attrgetter("start_ns")):
        if group and chunk.start_ns > end_ns:
            yield group
            group = []
        group.append(chunk)
        end_ns = max(end_ns, chunk.end_ns) if len(group) > 1 else chunk.end_ns
    if group:
        yield group


def _from(
    chunk: Chunk, wanted: Container[int], load: Load, skipped: Skipped, start_ns: int, end_ns: int
) -> Iterator[tuple[int, ChunkMessage | None]]:
    """The messages with their times, after an empty entry that keeps the chunk unread before its time."""
    yield chunk.start_ns, None
    try:
        contents, found, lacking = load(chunk, wanted)
    except MemoryError:
        raise
    except Exception as error:
        skipped.add(chunk, error)
        return
    if lacking:
        skipped.add_torn(chunk, lacking)
    found.sort()
    if found and not (chunk.start_ns <= found[0][0] and found[-1][0] <= chunk.end_ns):
        inside = [message for message in found if chunk.start_ns <= message[0] <= chunk.end_ns]
        skipped.add_torn(chunk, f"{len(found) - len(inside)} messages whose times are not the chunk's are left out")
        found = inside
    for record_ns, start, end, channel in found:
        if start_ns <= record_ns <= end_ns:
            yield record_ns, ChunkMessage(record_ns, channel, contents[start:end])
