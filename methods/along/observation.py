"""What a method sees at a tick along a recording or an episode, and what it can ask for."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from navtool.base.note import Note
from navtool.methods.along.streams import Streams


class Skip(NamedTuple):
    """Why a tick has no result."""

    reason: str
    """Counted by it, so without numbers of this one tick."""
    note: Note | None = None
    """What a user should look at; of each reason, the first one's is kept."""


class Reading[T](NamedTuple):
    """One message of the stream that ticks, decoded when it is wanted."""

    stamp_ns: int
    read: Callable[[], T | Skip]


class Ticks[T](ABC):
    """A stream that a method walks along: each of its messages is a tick.

    A further stream is a further class; the loop knows none of them.
    """

    reads: ClassVar[tuple[str, ...]]
    """The robot's streams that it is made of, by their names in ``robot.topics``; the first has to be there."""
    noun: ClassVar[str]
    """What its messages are called where they are counted, such as ``clouds``."""

    @abstractmethod
    def count(self, streams: Streams) -> int:
        """How many ticks there are."""

    @abstractmethod
    def duration_s(self, streams: Streams) -> float:
        """The time from the first tick to the last."""

    @abstractmethod
    def readings(self, streams: Streams) -> Iterator[Reading[T]]:
        """The ticks in the order of record; memory holds few of them."""


class Beside[T](ABC):
    """What is known at a tick of another stream, such as a pose, or a window of measurements before it."""

    reads: ClassVar[tuple[str, ...]]
    """The robot's streams that it is made of; it says what it says where they are not there."""

    @abstractmethod
    def at(self, streams: Streams, stamp_ns: int) -> T:
        """What is known at a moment; moments come in the order of the ticks."""


@dataclass(frozen=True, slots=True)
class Observation[T]:
    """A tick."""

    stamp_ns: int
    """On the clock of the recording."""
    reading: T
    """The message that ticks."""
    streams: Streams
    """What it is from."""

    def __getitem__[V](self, beside: Beside[V]) -> V:
        """What is known of something else at the tick; looked up when it is asked for."""
        return beside.at(self.streams, self.stamp_ns)
