"""How much work a recording is, so that equal parts of it take about as long."""

from dataclasses import dataclass

from navtool.datasets.ingest.segment import Segment

# Measured with frames and clouds at 10 Hz, by one worker: of the time of a recording the first pass took 13 %, the
# second 76 % and joining 9 %. Hashing, beside the first pass, takes about as long as reading alone.
_HASH, _FIRST_PASS, _READ, _JOIN = 1, 1, 12, 2
"""Units a byte."""
HASH_SHARE = _HASH / (_HASH + _FIRST_PASS)
"""Share of planning that is hashing."""


@dataclass(frozen=True, slots=True)
class Work:
    """Units of work that a recording's steps are expected to take."""

    planning: int = 0
    reading: int = 0
    joining: int = 0

    @property
    def total(self) -> int:
        """Work of all steps."""
        return self.planning + self.reading + self.joining

    def reading_of(self, segment: Segment, ticks: int) -> int:
        """The part of one segment of an episode; those of all segments add up to the whole.

        Args:
            ticks: Number of ticks of the episode.
        """
        end = segment.first_tick + segment.ticks
        return self.reading * end // ticks - self.reading * segment.first_tick // ticks


def work_of(size_bytes: int, *, dry_run: bool) -> Work:
    """The work of a recording that is new and has frames or clouds; a dry run only plans."""
    planning = (_HASH + _FIRST_PASS) * size_bytes
    return Work(planning) if dry_run else Work(planning, _READ * size_bytes, _JOIN * size_bytes)
