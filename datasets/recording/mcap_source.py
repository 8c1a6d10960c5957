"""MCAP recordings; chunks uncompressed or lz4 or zstd, with or without an index."""

import heapq
from collections import Counter
from collections.abc import Collection, Iterator
from operator import itemgetter
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.reader import SeekingReader
from mcap.records import Channel as ChannelRecord
from mcap.records import ChunkIndex, Message, Schema, Statistics
from mcap.stream_reader import StreamReader
from mcap.summary import Summary

from navtool.datasets.errors import DatasetsError
from navtool.datasets.recording.foreign import translated
from navtool.datasets.recording.mcap_chunk import ChunkMessage, chunk_messages
from navtool.datasets.recording.message_compression import decompressed
from navtool.datasets.recording.raw import RawMessage
from navtool.datasets.recording.source import Channel, Definition, normalised_type

_CURE = "if the recorder was stopped early or the copy is incomplete, run `mcap recover` or copy it again"
_COMPRESSIONS = ("", "lz4", "zstd")
_DEFINITION_FORMATS = {"ros1msg": "msg", "ros2msg": "msg", "ros2idl": "idl", "omgidl": "idl"}


class _Index(NamedTuple):
    """What the summary section says about the messages."""

    statistics: Statistics
    channels: dict[int, ChannelRecord]
    schemas: dict[int, Schema]
    chunks: list[ChunkIndex]


class McapSource:
    """One ``.mcap`` file, read chunk by chunk; their checksums are verified, and errors name the place."""

    def __init__(self, path: Path, *, where: Path) -> None:
        self._path = path
        self._where = where
        with translated("this MCAP recording cannot be opened", where=where):
            self._file: BinaryIO = path.open("rb")
        try:
            with translated("this MCAP recording cannot be read", where=where, cure=_CURE):
                self._reader = SeekingReader(self._file, validate_crcs=True)
                self._read_index()
        except DatasetsError:
            self.close()
            raise

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """The messages of the topics in the order of their record times."""
        wanted = {key: (c.topic, c.type) for key, c in self._channel_of.items() if c.topic in topics and c.count}
        with translated("this MCAP recording is damaged", where=self._where, cure=_CURE):
            if self._chunks is not None:
                streams = [_from(self._file, index, wanted) for index in self._chunks if _holds(index, wanted)]
                for record_ns, message in heapq.merge(*streams, key=itemgetter(0)):
                    if message is not None:
                        yield RawMessage(*wanted[message.channel_id], record_ns, decompressed(message.data))
                return
            if not self._sorted:
                raise DatasetsError(
                    "its messages are neither indexed nor in the order of their record times",
                    cure="run `mcap sort` on it",
                )
            with self._path.open("rb") as stream:
                for record in StreamReader(stream, validate_crcs=True).records:
                    if isinstance(record, Message) and record.channel_id in wanted:
                        yield RawMessage(*wanted[record.channel_id], record.log_time, decompressed(record.data))

    def close(self) -> None:
        """Let go of the file."""
        self._file.close()

    def _read_index(self) -> None:
        summary = self._reader.get_summary()
        index = None if summary is None else _complete(summary)
        if index is None:
            self._scan()
        else:
            statistics, channels, schemas, _ = index
            counts = statistics.channel_message_counts
            self._channel_of = {key: _channel(record, schemas, counts.get(key, 0)) for key, record in channels.items()}
            counted = statistics.message_count > 0
            self.span_ns = (statistics.message_start_time, statistics.message_end_time) if counted else None
        self._chunks = None if index is None else index.chunks
        self.channels = tuple(self._channel_of.values())

    def _scan(self) -> None:
        schemas: dict[int, Schema] = {}
        records: dict[int, ChannelRecord] = {}
        counts: Counter[int] = Counter()
        first_ns, last_ns, self._sorted = 2**64, -1, True
        with self._path.open("rb") as stream:
            for record in StreamReader(stream, validate_crcs=True).records:
                if isinstance(record, Schema):
                    schemas[record.id] = record
                elif isinstance(record, ChannelRecord):
                    records[record.id] = record
                elif isinstance(record, Message):
                    counts[record.channel_id] += 1
                    self._sorted = self._sorted and record.log_time >= last_ns
                    first_ns, last_ns = min(first_ns, record.log_time), max(last_ns, record.log_time)
        self._channel_of = {key: _channel(record, schemas, counts[key]) for key, record in records.items()}
        self.span_ns = (first_ns, last_ns) if counts else None


def _complete(summary: Summary) -> _Index | None:
    """The summary's parts, where it alone tells where each message is and what it is."""
    statistics = summary.statistics
    if statistics is None:
        return None
    if unknown := {x.compression for x in summary.chunk_indexes} - set(_COMPRESSIONS):
        raise DatasetsError(f"chunk compression {min(unknown)!r} is not supported; lz4 and zstd are")
    used = {key for chunk in summary.chunk_indexes for key in chunk.message_index_offsets}
    used |= set(statistics.channel_message_counts)
    described = used <= set(summary.channels) and all(
        x.schema_id == 0 or x.schema_id in summary.schemas for x in summary.channels.values()
    )
    counted = sum(statistics.channel_message_counts.values()) == statistics.message_count
    located = bool(summary.chunk_indexes) or statistics.message_count == 0
    if not (described and counted and located):
        return None
    return _Index(statistics, summary.channels, summary.schemas, summary.chunk_indexes)


def _holds(index: ChunkIndex, channel_ids: Collection[int]) -> bool:
    """Whether the chunk may hold messages of the channels; one without an index of its own may hold any."""
    return not index.message_index_offsets or any(key in index.message_index_offsets for key in channel_ids)


def _from(
    stream: BinaryIO, index: ChunkIndex, channel_ids: Collection[int]
) -> Iterator[tuple[int, ChunkMessage | None]]:
    """The messages with their times, after an empty entry that keeps the chunk unread before its time."""
    yield index.message_start_time, None
    for message in chunk_messages(stream, index, channel_ids):
        yield message.record_ns, message


def _channel(record: ChannelRecord, schemas: dict[int, Schema], count: int) -> Channel:
    schema = schemas.get(record.schema_id)
    if schema is None:
        return Channel(record.topic, "", record.message_encoding, None, count)
    definition = None
    if schema.data:
        form = _DEFINITION_FORMATS.get(schema.encoding, schema.encoding)
        definition = Definition(form, schema.data.decode(errors="replace"))
    return Channel(record.topic, normalised_type(schema.name), record.message_encoding, definition, count)
