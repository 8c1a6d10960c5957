"""One stream of a recording as its first pass keeps it."""

from dataclasses import dataclass, field
from itertools import compress
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float64, Int64

from navtool.base.note import Note
from navtool.datasets.decode.levels import LevelSurvey
from navtool.datasets.streams.video_survey import VideoSurvey
from navtool.pipeline.arrays import Array

_MOST = 1e15
"""No robot measures more, in whatever unit; sums and rates of such numbers still fit into the columns' float32."""


class Source(NamedTuple):
    """What tells the sensors apart that publish on one topic."""

    frame: str = ""
    """The frame in which it measures; of an odometry the child's."""
    parent: str = ""
    """The frame of an odometry's poses."""
    publisher: str = ""
    """The node, where the recording says so."""
    joints: tuple[str, ...] = ()
    """The joints that a message names, in its order."""


@dataclass(slots=True)
class RecordedStream:
    """What the first pass keeps of one stream, in the order of record."""

    topic: str
    header_ns: list[int] = field(default_factory=list)
    record_ns: list[int] = field(default_factory=list)
    rows: list[tuple[float, ...]] = field(default_factory=list)
    columns: tuple[str, ...] = ()
    joint_names: tuple[str, ...] = ()
    frame_id: str = ""
    undecodable: int = 0
    first_fault: str = ""
    native_size: tuple[int, int] | None = None
    notes: list[Note] = field(default_factory=list)
    """What is odd about the messages that were looked at."""
    video: VideoSurvey | None = None
    """Where its video can be decoded from; None where each message is a picture by itself."""
    survey: LevelSurvey | None = None
    """The range of the first pictures of 16 bits; None where they have 8."""
    beyond_measure: int = 0
    """Numbers that ``values`` left out."""
    sources: dict[Source, int] = field(default_factory=dict)
    """Who published, numbered in the order of their first messages."""
    source: list[int] = field(default_factory=list)
    """The number of each message's source."""
    native_sizes: dict[int, tuple[int, int]] = field(default_factory=dict)
    """Size of the first image or cloud of each source."""
    left_out: int = 0
    """Messages of other sources than the one that is read."""
    table: Float64[Array, "n columns"] | None = None
    """The rows, once they were joined."""
    present: Bool[Array, "n joints"] | None = None
    """Which joints each message names; None where all name all."""
    kept: Bool[Array, " n"] | None = None
    """Which images or clouds are read; None for all. Those that are not keep their place in the order of record."""

    def count(self, header_ns: int, record_ns: int, source: Source) -> None:
        """Count a message with its times and its source."""
        self.header_ns.append(header_ns)
        self.record_ns.append(record_ns)
        self.source.append(self.sources.setdefault(source, len(self.sources)))

    def leave_out(self, messages: Bool[Array, " n"]) -> None:
        """Take messages out: rows are removed, images and clouds keep their place and are not read."""
        self.left_out += int(np.count_nonzero(messages))
        kept = ~messages
        if self.rows:
            self.rows = list(compress(self.rows, kept))
            self.take(kept)
        else:
            self.kept = kept

    def take(self, messages: Bool[Array, " n"]) -> None:
        """Keep the times of these messages alone, and their values where they lie in a table."""
        self.header_ns, self.record_ns, self.source = (
            list(compress(entries, messages)) for entries in (self.header_ns, self.record_ns, self.source)
        )
        self.table = None if self.table is None else self.table[messages]
        self.present = None if self.present is None else self.present[messages]

    @property
    def read(self) -> bool:
        """Whether any of its messages is read."""
        return bool(self.record_ns) and (self.kept is None or bool(self.kept.any()))

    @property
    def stamps(self) -> tuple[Int64[Array, " n"], Int64[Array, " n"]]:
        """Header stamps (-1 without header) and record times in ns."""
        return np.array(self.header_ns, dtype=np.int64), np.array(self.record_ns, dtype=np.int64)

    def values(self) -> Float64[Array, "n columns"]:
        """The decoded rows of a small stream; numbers that are infinite or beyond 1e15 become NaN and are counted."""
        table = self._rows_as_table() if self.table is None else self.table.copy()
        beyond = np.abs(table) > _MOST
        self.beyond_measure = int(np.count_nonzero(beyond))
        table[beyond] = np.nan
        return table

    def _rows_as_table(self) -> Float64[Array, "n columns"]:
        return np.array(self.rows, dtype=np.float64).reshape(len(self.rows), len(self.columns))
