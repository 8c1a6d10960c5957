"""One stream of a recording as its first pass keeps it."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64, Int64

from navtool.base.note import Note
from navtool.datasets.decode.levels import LevelSurvey
from navtool.datasets.streams.video_survey import VideoSurvey
from navtool.pipeline.arrays import Array

_MOST = 1e15
"""No robot measures more, in whatever unit; sums and rates of such numbers still fit into the columns' float32."""


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

    @property
    def stamps(self) -> tuple[Int64[Array, " n"], Int64[Array, " n"]]:
        """Header stamps (-1 without header) and record times in ns."""
        return np.array(self.header_ns, dtype=np.int64), np.array(self.record_ns, dtype=np.int64)

    def values(self) -> Float64[Array, "n columns"]:
        """The decoded rows of a small stream; numbers that are infinite or beyond 1e15 become NaN and are counted."""
        table = np.array(self.rows, dtype=np.float64).reshape(len(self.rows), len(self.columns))
        beyond = np.abs(table) > _MOST
        self.beyond_measure = int(np.count_nonzero(beyond))
        table[beyond] = np.nan
        return table
