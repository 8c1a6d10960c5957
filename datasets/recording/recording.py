"""A recording, whatever its format: its topics, its messages in time order, their stamps and their contents."""

import heapq
import struct
from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import TracebackType

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.messages import Decoded
from navtool.datasets.decode.table import MESSAGES
from navtool.datasets.recording.foreign import describe
from navtool.datasets.recording.message_type import MessageType, StampLayout, message_type
from navtool.datasets.recording.raw import RawMessage, RecordingFormat, Topic
from navtool.datasets.recording.schema_types import JsonType, ProtobufType, schema_type
from navtool.datasets.recording.source import END_NS, Channel, Source

type AnyType = MessageType | JsonType | ProtobufType


class Recording:
    """One recording, of one file or of the files it was split into; `open_recording` makes it.

    Reading streams: memory holds the chunks around the current time and the index, never the whole recording. Nothing
    is written beside the files. Every fault is a `DatasetsError` that names the file, and the topic and record time
    where it is one message's. A type that cannot be decoded is listed like the others and hinders none of them.

    Attributes:
        path: What was opened, a file or a folder.
        format: How it is stored.
        start_ns: Record time of the first message; 0 without messages.
        end_ns: Record time of the last message; 0 without messages.
        message_count: Of all topics.
        topics: By name; those without messages included.
        bytes_left: Numbers of messages, of those that were decoded, by the bytes behind their last field, by topic.
    """

    def __init__(
        self,
        path: Path,
        recording_format: RecordingFormat,
        sources: Sequence[Source],
        *,
        ros_distro: str,
        resources: ExitStack,
        notes: Sequence[Note] = (),
        faults: Sequence[str] = (),
    ) -> None:
        self.path = path
        self.format = recording_format
        self._sources = sorted(sources, key=lambda source: source.span_ns or (0, 0))
        self._resources = resources
        self._open = True
        self._notes, self._faults = tuple(notes), tuple(faults)
        self._ros_distro = ros_distro
        self._types: dict[tuple[str, str], AnyType | DatasetsError] = {}
        self._stamps: dict[tuple[str, str], StampLayout | JsonType | ProtobufType | None] = {}
        self.bytes_left: dict[str, Counter[int]] = {}
        self._channels: dict[tuple[str, str], list[Channel]] = {}
        for channel in (channel for source in sources for channel in source.channels):
            self._channels.setdefault((channel.topic, channel.type), []).append(channel)
        self.topics = tuple(
            Topic(name, kind, sum(channel.count for channel in channels))
            for (name, kind), channels in sorted(self._channels.items())
        )
        self.message_count = sum(topic.count for topic in self.topics)
        spans = [source.span_ns for source in sources if source.span_ns is not None]
        self.start_ns = min((first for first, _ in spans), default=0)
        self.end_ns = max((last for _, last in spans), default=0)

    def __enter__(self) -> "Recording":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def close(self) -> None:
        """Let go of the files; the description stays readable, the messages do not."""
        self._open = False
        self._resources.close()

    def messages(
        self, topics: Collection[str], start_ns: int | None = None, end_ns: int | None = None
    ) -> Iterator[RawMessage]:
        """The messages of the topics, in the order of their record times.

        Args:
            topics: Names of topics; none gives no messages.
            start_ns: Record time of the first message to give; None begins with the first.
            end_ns: Record time of the last one; None ends with the last.

        Raises:
            DatasetsError: The recording has no topic of such a name; while iterating: it is damaged.
        """
        self._check_open()
        known = {topic.name for topic in self.topics}
        if missing := sorted(set(topics) - known):
            raise DatasetsError(
                f"no topic {', '.join(missing)}",
                where=self.path,
                cure=f"choose from {', '.join(sorted(known)) or 'nothing: the recording has no topics'}",
            )
        wanted, first, last = frozenset(topics), start_ns or 0, END_NS if end_ns is None else end_ns
        inside = [
            (x.span_ns[0], x) for x in self._sources if x.span_ns and x.span_ns[1] >= first and x.span_ns[0] <= last
        ]
        if len(inside) == 1:
            return self._while_open(inside[0][1].messages(wanted, first, last))
        return self._merged([_from(start, source.messages(wanted, first, last)) for start, source in inside])

    @property
    def files(self) -> tuple[Path, ...]:
        """The files that it consists of, in the order of their beginnings."""
        return tuple(source.where for source in self._sources)

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with the files, as far as they were read: what had to be skipped or done without."""
        parts = [(source.where, fault) for source in self._sources for fault in source.faults]
        named = (fault if len(self._sources) == 1 else f"{where.name}: {fault}" for where, fault in parts)
        return (*self._faults, *named)

    def notes(self) -> list[Note]:
        """What was done about its files, and about definitions of its types as far as they were needed."""
        completed = [
            Note("definition.completed", f"{topic}: {kind.told}")
            for (topic, _), kind in sorted(self._types.items(), key=lambda item: item[0])
            if not isinstance(kind, DatasetsError) and kind.told
        ]
        return [*self._notes, *completed]

    def header_stamp_ns(self, raw: RawMessage) -> int | None:
        """The header's stamp, read from the bytes; 0 where it was left unset, None where the type has no header.

        None also where the type is unknown: whether it has a header is not known then.

        Raises:
            DatasetsError: The message is shorter than its header.
        """
        layout = self._stamp_layout(raw)
        if layout is None:
            return None
        try:
            return layout.stamp_ns(raw.data)
        except Exception as error:
            raise self._fault(raw, f"its header cannot be read: {describe(error)}") from error

    def header_frame(self, raw: RawMessage) -> str:
        """The header's frame, read from the bytes; empty where the type has no header of ROS's, or it is damaged."""
        layout = self._stamp_layout(raw)
        if not isinstance(layout, StampLayout):
            return ""
        try:
            return layout.frame_id(raw.data)
        except (struct.error, UnicodeDecodeError, IndexError):
            return ""

    def _stamp_layout(self, raw: RawMessage) -> StampLayout | JsonType | ProtobufType | None:
        key = (raw.topic, raw.type)
        if key not in self._stamps:
            try:
                self._stamps[key] = self._type_of(raw).stamp_layout
            except DatasetsError:
                self._stamps[key] = None
        return self._stamps[key]

    def layout_of(self, raw: RawMessage) -> tuple[str, tuple[object, ...]] | None:
        """Encoding and fields of the message's type; None where its definition cannot be read."""
        try:
            kind = self._type_of(raw)
        except DatasetsError:
            return None
        return kind.encoding, kind.layout()

    def decode(self, raw: RawMessage) -> Decoded:
        """The contents of a message.

        Raises:
            DatasetsError: navtool has no decoder for the type, its definition is missing or the bytes are damaged.
        """
        message = MESSAGES.get(raw.type)
        if message is None:
            raise self._fault(raw, "there is no decoder for the type", f"decodable are {', '.join(sorted(MESSAGES))}")
        try:
            read = self._type_of(raw).read(raw.data)
            if read.left_bytes:
                self.bytes_left.setdefault(raw.topic, Counter())[read.left_bytes] += 1
            return message.decode(read.message)
        except DatasetsError as error:
            raise self._fault(raw, error.what, error.cure) from error
        except Exception as error:
            raise self._fault(raw, f"the message cannot be decoded: {describe(error)}") from error

    def _merged(self, streams: list[Iterator[tuple[int, RawMessage | None]]]) -> Iterator[RawMessage]:
        for _, raw in heapq.merge(*streams, key=lambda item: item[0]):
            self._check_open()
            if raw is not None:
                yield raw

    def _while_open(self, messages: Iterator[RawMessage]) -> Iterator[RawMessage]:
        self._check_open()
        for raw in messages:
            yield raw
            self._check_open()

    def _check_open(self) -> None:
        if not self._open:
            raise DatasetsError("the recording is closed", where=self.path, cure="read it inside the with block")

    def _type_of(self, raw: RawMessage) -> AnyType:
        key = (raw.topic, raw.type)
        if key not in self._types:
            try:
                self._types[key] = self._read_type(key)
            except DatasetsError as error:
                self._types[key] = error
            except Exception as error:
                self._types[key] = DatasetsError(f"its definition cannot be read: {describe(error)}")
        found = self._types[key]
        if isinstance(found, DatasetsError):
            raise DatasetsError(found.what, cure=found.cure) from found
        return found

    def _read_type(self, key: tuple[str, str]) -> AnyType:
        channels = self._channels.get(key)
        if channels is None:
            raise DatasetsError("the message is not one of this recording")
        definitions = {(channel.encoding, channel.definition, channel.md5sum): channel for channel in channels}
        first, *others = (_made(x, self._ros_distro) for x in definitions.values())
        if any((other.encoding, other.layout()) != (first.encoding, first.layout()) for other in others):
            raise DatasetsError("the topic carries two different types of this name", cure="filter one publisher out")
        return first

    def _fault(self, raw: RawMessage, what: str, cure: str | None = None) -> DatasetsError:
        return DatasetsError(what, where=f"{self.path}: {raw.topic} ({raw.type}) at {raw.record_ns} ns", cure=cure)


def _made(channel: Channel, ros_distro: str) -> AnyType:
    if channel.encoding in ("json", "protobuf"):
        return schema_type(channel.type, channel.encoding, channel.definition)
    return message_type(channel.type, channel.encoding, channel.definition, ros_distro, channel.md5sum)


def _from(start_ns: int, messages: Iterator[RawMessage]) -> Iterator[tuple[int, RawMessage | None]]:
    """The messages by time, after an empty entry that keeps a later part of the recording unread before its time."""
    yield start_ns, None
    for raw in messages:
        yield raw.record_ns, raw
