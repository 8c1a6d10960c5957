"""One stream's way into the rows of a segment."""

import logging
from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float32

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import Decoded, ImageFrame, PointCloud
from navtool.datasets.ingest.odd_messages import OddMessages
from navtool.datasets.ingest.segment import StreamPart
from navtool.datasets.recording import RawMessage, Recording
from navtool.pipeline.arrays import Array

logger = logging.getLogger(__name__)


class Lane(ABC):
    """Takes a stream's messages as they were recorded and writes its part of the rows in the order of ticks.

    A message that cannot be decoded leaves its ticks without it and is counted; so does one that never comes. Lanes
    share nothing: each may work in a thread of its own.

    Args:
        stream: Its name.
        part: What the segment reads of the stream; None where the recording has none.
        ticks: Rows of the segment.
        keys: Columns that the lane fills, as numbers.
    """

    def __init__(self, stream: str, part: StreamPart | None, ticks: int, keys: Sequence[str]) -> None:
        self.columns: dict[str, Array] = {key: np.zeros(ticks, dtype=np.float32) for key in keys}
        self.lost: list[int] = []
        """Ticks whose message cannot be decoded or never came."""
        self.undecodable = 0
        self.odd = OddMessages()
        self._stream = stream
        self._part = part or StreamPart("", 0, np.zeros(0, dtype=np.int64), {}, frozenset(), {})
        self._waits = np.zeros(ticks, dtype=np.bool_)
        self._waits[[tick for served in self._part.segment_ticks.values() for tick in served]] = True
        self._next = 0

    def take(self, recording: Recording, raw: RawMessage, position: int) -> None:
        """Use the message at a position of the stream's order of record."""
        ticks = self._part.segment_ticks.get(position, [])
        if not ticks and not self._wanted(position):
            return
        try:
            sample = self._seen(recording.decode(raw))
        except DatasetsError as error:
            logger.debug("%s: %s", raw.topic, error)
            self.undecodable += position in self._part.own
            self._give_up(ticks)
        else:
            if ticks or position in self._part.own:
                self._add_odd(sample)
            self._use(sample, ticks, raw, position)
            self._waits[ticks] = False
        self._settle()

    def finish(self) -> None:
        """Write what is left; ticks whose message never came are without it."""
        self._give_up(np.flatnonzero(self._waits).tolist())
        self._settle()

    def _add_odd(self, sample: Decoded) -> None:
        """Count what is odd about a message."""
        self.odd.add(self._stream, sample.notes if isinstance(sample, ImageFrame | PointCloud) else ())

    def _seen(self, sample: Decoded) -> Decoded:
        """The sample as it is to be used."""
        return sample

    def _wanted(self, position: int) -> bool:  # noqa: ARG002 - for those that want more
        """Whether a message that serves no tick is to be used all the same."""
        return False

    @abstractmethod
    def _use(self, sample: Decoded, ticks: list[int], raw: RawMessage, position: int) -> None:
        """Make of a message what its ticks need."""

    @abstractmethod
    def _write(self, tick: int) -> None:
        """Write a row's part."""

    def _set_reliability(self, ticks: list[int], values: Sequence[float]) -> None:
        for key, value in zip(self.columns, values, strict=True):
            column: Float32[Array, " ticks"] = self.columns[key]
            column[ticks] = value

    def _give_up(self, ticks: list[int]) -> None:
        self.lost.extend(ticks)
        self._waits[ticks] = False

    def _settle(self) -> None:
        """Write every row that waits for nothing more."""
        while self._next < self._waits.size and not self._waits[self._next]:
            self._write(self._next)
            self._next += 1
