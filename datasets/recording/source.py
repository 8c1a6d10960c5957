"""What the facade asks of each storage format: one file, its channels, its messages in time order."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, Protocol, runtime_checkable

from navtool.datasets.recording.raw import RawMessage

END_NS = 2**63 - 1
"""Later than any message."""


class Definition(NamedTuple):
    """A message definition as embedded in the recording."""

    format: str
    """``msg``, ``idl`` or ``protobuf`` (its descriptors as latin-1); others are not read."""
    text: str


class Read(NamedTuple):
    """A message as an object, and what its type leaves of the bytes."""

    message: Any
    left_bytes: int = 0
    """Bytes behind the last field, beyond what pads a message."""


@dataclass(frozen=True, slots=True)
class Channel:
    """A stream of equally encoded messages; several channels may share a topic."""

    topic: str
    type: str
    encoding: str
    """``ros1``, ``cdr``, ``json`` or ``protobuf``; others are listed but cannot be decoded."""
    definition: Definition | None
    """None where the recording embeds none."""
    count: int
    md5sum: str = ""
    """The type's checksum as ROS 1 counts it; empty where the recording does not say it."""


@runtime_checkable
class Source(Protocol):
    """One opened file."""

    where: Path
    """As the user named it."""

    @property
    def channels(self) -> tuple[Channel, ...]:
        """Its channels, those without messages included."""

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """Record times of the first and the last message; None without messages."""

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with the file, as far as it was read; empty for a sound one."""

    def messages(self, topics: Collection[str], start_ns: int = 0, end_ns: int = END_NS) -> Iterator[RawMessage]:
        """The messages of the topics within the times, both included, in the order of their record times."""

    def close(self) -> None:
        """Let go of the file."""


def normalised_type(name: str) -> str:
    """``package/msg/Name`` for the ``package/Name`` of ROS 1 and of old recorders; other names as they are."""
    parts = name.split("/")
    return f"{parts[0]}/msg/{parts[1]}" if len(parts) == 2 and all(parts) else name
