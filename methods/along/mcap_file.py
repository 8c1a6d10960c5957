"""Results as ROS 2 messages in an MCAP, which viewers of robot data open."""

from collections.abc import Iterable
from pathlib import Path
from types import TracebackType
from typing import Any, NamedTuple, Protocol, runtime_checkable

from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter

from navtool.methods.along.writers import Outcome, Selection, Writer

_CHUNK_BYTES = 4 << 20


class Message(NamedTuple):
    """A message as it is recorded."""

    topic: str
    data: bytes
    """As CDR."""


@runtime_checkable
class Messages[R](Protocol):
    """Builds the messages of results."""

    @property
    def topics(self) -> dict[str, str]:
        """Every topic with its type."""

    def definition(self, type_name: str) -> str:
        """The type's definition with all that it refers to."""

    def of(self, outcome: Outcome[R]) -> Iterable[Message]:
        """The messages of a result, transforms first."""


class McapFile[R](Writer[R]):
    """Writes the messages of results at their stamps; memory holds one chunk.

    The same results give the same bytes. Leaving it without an error finishes the file.
    """

    def __init__(self, path: Path, messages: Messages[R], selection: Selection | None = None) -> None:
        super().__init__("mcap", selection)
        self._messages = messages
        self._file = path.open("wb")
        self._writer: Any = McapWriter(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="navtool")
        self._channels: dict[str, int] = {}
        for topic, kind in messages.topics.items():
            schema = self._writer.register_schema(kind, "ros2msg", messages.definition(kind).encode())
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)

    def write(self, outcome: Outcome[R]) -> None:
        """Write a result's messages."""
        moment_ns = outcome.stamp_ns
        for topic, data in self._messages.of(outcome):
            self._writer.add_message(self._channels[topic], moment_ns, data, moment_ns, outcome.number)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._writer.finish()
        self._file.close()
