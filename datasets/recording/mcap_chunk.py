"""The messages of one MCAP chunk.

The library's own reader makes an object of every record, those of unwanted topics too, and keeps them in a heap that
compares in Python: many times the time of this for topics of hundreds of hertz.
"""

import struct
from collections.abc import Container, Iterator
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Chunk, ChunkIndex
from mcap.stream_reader import get_chunk_data_stream

_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")


class ChunkMessage(NamedTuple):
    """A message as the chunk holds it."""

    record_ns: int
    channel_id: int
    data: bytes


def chunk_messages(stream: BinaryIO, index: ChunkIndex, channel_ids: Container[int]) -> Iterator[ChunkMessage]:
    """The chunk's messages of the channels in the order of their record times; it is read when the first is taken.

    Raises:
        mcap.exceptions.McapError: The chunk cannot be decompressed.
        ValueError: Its checksum differs, or its records do not fit into it.
    """
    stream.seek(index.chunk_start_offset + _RECORD.size)
    contents, size = get_chunk_data_stream(Chunk.read(ReadDataStream(stream)), validate_crc=True)
    records = contents.read(size)
    found: list[tuple[int, int, int, int]] = []
    place = 0
    while place < size:
        opcode, length = _RECORD.unpack_from(records, place)
        place += _RECORD.size
        if opcode == Opcode.MESSAGE:
            channel_id, _, log_time, _ = _MESSAGE.unpack_from(records, place)
            if channel_id in channel_ids:
                found.append((log_time, place + _MESSAGE.size, place + length, channel_id))
        place += length
    if place != size:
        raise ValueError(f"the records of the chunk at byte {index.chunk_start_offset} reach beyond its end")
    found.sort()
    for log_time, start, end, channel_id in found:
        yield ChunkMessage(log_time, channel_id, records[start:end])
