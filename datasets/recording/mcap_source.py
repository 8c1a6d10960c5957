"""MCAP recordings; chunks uncompressed or lz4 or zstd, with or without an index, whole or damaged."""

from collections import Counter
from collections.abc import Collection, Container, Iterator
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

from mcap.data_stream import ReadDataStream
from mcap.reader import SeekingReader
from mcap.records import Channel as ChannelRecord
from mcap.records import Schema
from mcap.summary import Summary

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import mcap_file
from navtool.datasets.recording.chunks import Chunk, Contents, Skipped, merged
from navtool.datasets.recording.file_bytes import FileBytes
from navtool.datasets.recording.foreign import describe, translated
from navtool.datasets.recording.message_compression import decompressed
from navtool.datasets.recording.raw import RawMessage
from navtool.datasets.recording.source import END_NS, Channel, Definition, normalised_type

_CURE = "copy it again from where it was recorded"
_DEFINITION_FORMATS = {"ros1msg": "msg", "ros2msg": "msg", "ros2idl": "idl", "omgidl": "idl"}
_LOOSE_BYTES = 1 << 22
"""Messages outside of chunks are read in portions of about this size."""


class McapSource:
    """One ``.mcap`` file, read chunk by chunk; checksums are verified by default, and errors say where.

    The summary at its end says what each chunk holds. Where there is none, or where it does not fit the file, every
    record is looked at once, in the order of the file, to its end; whatever cannot be read is skipped and named
    in ``faults``.
    """

    def __init__(self, path: Path, *, where: Path, verify: bool = True) -> None:
        self.where = where
        self._verify = verify
        self._found: list[str] = []
        self._schemas: dict[int, Schema] = {}
        self._records: dict[int, ChannelRecord] = {}
        self._counts: Counter[int] = Counter()
        self._loose: dict[int, int] = {}
        with translated("this MCAP recording cannot be opened", where=where):
            self._content = FileBytes(path)
        try:
            with translated("this MCAP recording cannot be read", where=where, cure=_CURE), path.open("rb") as file:
                self._chunks = self._by_summary(file)
                if not self._counts and self._found:
                    raise DatasetsError(f"nothing in it can be read: {'; '.join(self._found)}", cure=_CURE)
        except DatasetsError:
            self.close()
            raise
        self._skipped = Skipped(len(self._chunks))
        self._channel_of = {
            key: _channel(record, self._schemas, self._counts[key]) for key, record in self._records.items()
        }
        self.channels = tuple(self._channel_of.values())
        spans = [(chunk.start_ns, chunk.end_ns) for chunk in self._chunks]
        counted = bool(self._counts.total())
        self.span_ns = (min(a for a, _ in spans), max(b for _, b in spans)) if spans and counted else None

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with the file, as far as it was read; empty for a sound one."""
        return (*self._found, *self._skipped.faults())

    def messages(self, topics: Collection[str], start_ns: int = 0, end_ns: int = END_NS) -> Iterator[RawMessage]:
        """The messages of the topics within the times, in the order of their record times."""
        wanted = {key: (c.topic, c.type) for key, c in self._channel_of.items() if c.topic in topics and c.count}
        with translated("this MCAP recording is damaged", where=self.where, cure=_CURE):
            for message in merged(self._chunks, wanted, self._load, self._skipped, start_ns, end_ns):
                yield RawMessage(*wanted[message.channel], message.record_ns, decompressed(message.data))

    def close(self) -> None:
        """Let go of the file."""
        self._content.close()

    def _load(self, chunk: Chunk, wanted: Container[int]) -> Contents:
        if chunk.offset in self._loose:
            return mcap_file.messages_in(self._content[chunk.offset : self._loose[chunk.offset]], wanted)
        record = mcap_file.record_at(self._content, chunk.offset, len(self._content))
        if record.op != mcap_file.CHUNK:
            raise ValueError("there is no chunk")
        head = mcap_file.chunk_head(self._content, record)
        return mcap_file.messages_in(mcap_file.chunk_contents(self._content, head, verify=self._verify), wanted)

    def _by_summary(self, file: BinaryIO) -> list[Chunk]:
        """The chunks as the summary lists them, or as they are found in the order of the file."""
        try:
            summary = SeekingReader(file, validate_crcs=True).get_summary()
        except Exception as error:
            self._found.append(f"no usable summary ({describe(error)}): read in the order of the file")
            return self._by_looking()
        if summary is not None and not _inside(summary, len(self._content)):
            self._found.append("the summary does not fit the file: read in the order of the file")
            return self._by_looking()
        if summary is None or not _complete(summary) or summary.statistics is None:
            return self._by_looking()
        self._schemas, self._records = summary.schemas, summary.channels
        self._counts.update(summary.statistics.channel_message_counts)
        return [
            Chunk(
                index.chunk_start_offset,
                index.chunk_length,
                index.message_start_time,
                index.message_end_time,
                frozenset(index.message_index_offsets),
                packed=bool(index.compression),
            )
            for index in summary.chunk_indexes
        ]

    def _by_looking(self) -> list[Chunk]:
        """The chunks in the order of the file, each looked into, and portions of messages that are in none."""
        size = len(self._content)
        offset = len(mcap_file.MAGIC)
        chunks: list[Chunk] = []
        loose = _Loose()
        while offset < size:
            try:
                record = mcap_file.record_at(self._content, offset, size)
            except ValueError as error:
                following = mcap_file.next_chunk(self._content, offset + 1)
                lost = (size if following is None else following) - offset
                self._found.append(f"{lost} bytes skipped at byte {offset} of {size}: {error}")
                if following is None:
                    break
                chunks += loose.rest()
                offset = following
                continue
            if record.op == mcap_file.DATA_END:
                break
            if record.end > size:
                self._found.append(f"cut off after {size / 1e6:.3f} MB, within a record of {record.end - offset} bytes")
            if record.op == mcap_file.CHUNK:
                chunks += self._looked_into(record)
            elif record.end <= size:
                chunks += loose.take(self._taken(self._content, record), record)
            offset = record.end
        chunks += loose.rest()
        self._loose = loose.ends
        if lost := sum(count for key, count in self._counts.items() if key not in self._records):
            self._found.append(f"{lost} messages skipped: the records that name their topic are lost")
        return chunks

    def _looked_into(self, record: mcap_file.Record) -> list[Chunk]:
        try:
            head = mcap_file.chunk_head(self._content, record)
            contents = mcap_file.chunk_contents(self._content, head)
        except Exception as error:
            what = error.what if isinstance(error, DatasetsError) else describe(error)
            self._found.append(f"the chunk at byte {record.offset} is skipped: {what}")
            return []
        found = [message for inner in mcap_file.records(contents) if (message := self._taken(contents, inner))]
        if not found:
            return []
        times = [record_ns for _, record_ns in found]
        channels = frozenset(channel for channel, _ in found)
        packed = bool(head.compression)
        return [Chunk(record.offset, record.end - record.offset, min(times), max(times), channels, packed)]

    def _taken(self, content: bytes | FileBytes, record: mcap_file.Record) -> tuple[int, int] | None:
        """Like ``_take``; a record that is not what it says is named and left out."""
        try:
            return self._take(content, record)
        except Exception as error:
            self._found.append(f"a record at byte {record.offset} is skipped: {describe(error)}")
            return None

    def _take(self, content: bytes | FileBytes, record: mcap_file.Record) -> tuple[int, int] | None:
        """Note a schema or a channel; channel and record time of a message."""
        if record.op == mcap_file.MESSAGE:
            channel, record_ns = mcap_file.message_head(content, record)
            self._counts[channel] += 1
            return channel, record_ns
        if record.op in (mcap_file.SCHEMA, mcap_file.CHANNEL):
            stream = ReadDataStream(BytesIO(content[record.start : record.end]))
            if record.op == mcap_file.SCHEMA:
                schema = Schema.read(stream)
                self._schemas[schema.id] = schema
            else:
                described = ChannelRecord.read(stream)
                self._records[described.id] = described
        return None


class _Loose:
    """Gathers messages outside of chunks into portions."""

    def __init__(self) -> None:
        self.ends: dict[int, int] = {}
        self._start = 0
        self._end = 0
        self._messages: list[tuple[int, int]] = []

    def take(self, message: tuple[int, int] | None, record: mcap_file.Record) -> list[Chunk]:
        """Add a record; the portion that is full with it, or nothing."""
        if message is None and not self._messages:
            return []
        if not self._messages:
            self._start = record.offset
        self._end = record.end
        if message is not None:
            self._messages.append(message)
        return self.rest() if self._end - self._start > _LOOSE_BYTES else []

    def rest(self) -> list[Chunk]:
        """The current portion, if there is one."""
        if not self._messages:
            return []
        times = [record_ns for _, record_ns in self._messages]
        self.ends[self._start] = self._end
        channels = frozenset(channel for channel, _ in self._messages)
        self._messages = []
        return [Chunk(self._start, self._end - self._start, min(times), max(times), channels)]


def _inside(summary: Summary, size: int) -> bool:
    """Whether the chunks that the summary lists can lie in the file."""
    return all(
        chunk.chunk_start_offset + chunk.chunk_length <= size and chunk.message_start_time <= chunk.message_end_time
        for chunk in summary.chunk_indexes
    )


def _complete(summary: Summary) -> bool:
    """Whether the summary alone says where each message is and what it is."""
    statistics = summary.statistics
    if statistics is None:
        return False
    used = {key for chunk in summary.chunk_indexes for key in chunk.message_index_offsets}
    used |= set(statistics.channel_message_counts)
    described = used <= set(summary.channels) and all(
        x.schema_id == 0 or x.schema_id in summary.schemas for x in summary.channels.values()
    )
    counted = sum(statistics.channel_message_counts.values()) == statistics.message_count
    located = bool(summary.chunk_indexes) or statistics.message_count == 0
    known = all(chunk.compression in mcap_file.COMPRESSIONS for chunk in summary.chunk_indexes)
    return described and counted and located and known


def _channel(record: ChannelRecord, schemas: dict[int, Schema], count: int) -> Channel:
    schema = schemas.get(record.schema_id)
    if schema is None:
        return Channel(record.topic, "", record.message_encoding, None, count)
    definition, md5sum = None, record.metadata.get("md5sum", "")
    if schema.data:
        form = _DEFINITION_FORMATS.get(schema.encoding, schema.encoding)
        # A protobuf schema is bytes: as latin-1 it is a text that gives them back.
        text = schema.data.decode("latin-1") if form == "protobuf" else schema.data.decode(errors="replace")
        definition = Definition(form, text)
    return Channel(record.topic, normalised_type(schema.name), record.message_encoding, definition, count, md5sum)
