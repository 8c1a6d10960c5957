"""The records of an MCAP file and of its chunks, read by their own lengths and nothing else.

The library's readers stop at the first fault, and make an object of every record, those of unwanted topics too.
"""

import struct
import zlib
from collections.abc import Container, Iterator
from typing import NamedTuple

import lz4.frame
import zstandard

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.chunks import MOST_BYTES, Contents
from navtool.datasets.recording.file_bytes import FileBytes

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x03, 0x04, 0x05, 0x06, 0x0F
COMPRESSIONS = ("", "lz4", "zstd")
_RECORD = struct.Struct("<BQ")
_MESSAGE = struct.Struct("<HIQQ")
_CHUNK = struct.Struct("<QQQI")
_KNOWN = range(0x01, 0x10)
_LENGTH = struct.Struct("<I")


class Record(NamedTuple):
    """A record: its kind, and where its content lies."""

    op: int
    offset: int
    start: int
    end: int


class ChunkHead(NamedTuple):
    """What a chunk says before its records."""

    start_ns: int
    end_ns: int
    size: int
    crc: int
    compression: str
    start: int
    end: int


def record_at(content: bytes | FileBytes, offset: int, limit: int) -> Record:
    """The record at an offset; its end may lie beyond the limit.

    Raises:
        ValueError: There is none.
    """
    if offset + _RECORD.size > limit:
        raise ValueError(f"the record at byte {offset} is cut off")
    op, length = _RECORD.unpack(content[offset : offset + _RECORD.size])
    if op not in _KNOWN:
        raise ValueError(f"there is no record at byte {offset}")
    return Record(op, offset, offset + _RECORD.size, offset + _RECORD.size + length)


def records(content: bytes, limit: int | None = None) -> Iterator[Record]:
    """The whole records of a chunk's content, up to the first that is none."""
    offset, size = 0, len(content) if limit is None else limit
    while offset < size:
        try:
            record = record_at(content, offset, size)
        except ValueError:
            return
        if record.end > size:
            return
        yield record
        offset = record.end


def message_head(content: bytes | FileBytes, record: Record) -> tuple[int, int]:
    """Channel and record time of a message."""
    if record.end - record.start < _MESSAGE.size:
        raise ValueError(f"the message at byte {record.offset} is shorter than its head")
    channel, _, log_time, _ = _MESSAGE.unpack(content[record.start : record.start + _MESSAGE.size])
    return channel, log_time


def chunk_head(content: FileBytes, record: Record) -> ChunkHead:
    """A chunk's head.

    Raises:
        ValueError: It reaches beyond the chunk.
    """
    limit = min(record.end, len(content))
    at = record.start + _CHUNK.size
    if at + 4 > limit:
        raise ValueError(f"the chunk at byte {record.offset} is cut off")
    first, last, size, crc = _CHUNK.unpack(content[record.start : at])
    length = _LENGTH.unpack(content[at : at + 4])[0]
    at += 4 + length
    if at + 8 > limit:
        raise ValueError(f"the chunk at byte {record.offset} is cut off")
    compression = content[at - length : at].decode(errors="replace")
    packed = int.from_bytes(content[at : at + 8], "little")
    return ChunkHead(first, last, size, crc, compression, at + 8, at + 8 + packed)


def next_chunk(content: FileBytes, offset: int) -> int | None:
    """Where the next compressed chunk begins whose head can be read; None where there is none."""
    marks = [_LENGTH.pack(len(name)) + name.encode() for name in COMPRESSIONS if name]
    before = _RECORD.size + _CHUNK.size
    found = [content.find(mark, offset) for mark in marks]
    while any(at != -1 for at in found):
        at = min(at for at in found if at != -1)
        start = at - before
        if start >= offset:
            try:
                record = record_at(content, start, len(content))
                head = chunk_head(content, record)
            except ValueError:
                record, head = None, None
            if record is not None and head is not None and record.op == CHUNK and head.end == record.end:
                return start
        found = [content.find(mark, at + 1) if old == at else old for mark, old in zip(marks, found, strict=True)]
    return None


def chunk_contents(content: FileBytes, head: ChunkHead, *, verify: bool = True) -> bytes:
    """A chunk's records, decompressed and checked; of a chunk that is cut off, what can be had of them.

    Args:
        verify: Whether the checksum is compared, at about a gigabyte a second.

    Raises:
        DatasetsError: The compression is unknown, the chunk is beyond all measure, or its checksum differs.
        Exception: Whatever the decompressor says of damaged data.
    """
    if head.size > MOST_BYTES:
        raise DatasetsError(f"a chunk of {head.size} bytes")
    cut = head.end > len(content)
    packed = content[head.start : head.end]
    contents = _unpacked(packed, head, cut=cut)
    if cut:
        return contents
    if len(contents) != head.size:
        raise DatasetsError(f"{len(contents)} bytes where {head.size} are announced")
    if verify and head.crc and zlib.crc32(contents) != head.crc:
        raise DatasetsError("its checksum differs")
    return contents


def _unpacked(packed: bytes, head: ChunkHead, *, cut: bool) -> bytes:
    match head.compression:
        case "":
            return packed
        case "lz4":
            return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=head.size))
        case "zstd" if cut:
            return zstandard.ZstdDecompressor().decompressobj().decompress(packed)[: head.size]
        case "zstd":
            # A frame may announce its size itself, and the library would make room for whatever it says.
            announced = zstandard.frame_content_size(packed)
            if announced not in (-1, head.size):
                raise DatasetsError(f"a frame of {announced} bytes where {head.size} are announced")
            return zstandard.ZstdDecompressor().decompress(packed, max_output_size=head.size)
        case other:
            raise DatasetsError(f"chunk compression {other!r} is not supported; lz4 and zstd are")


def messages_in(contents: bytes, wanted: Container[int]) -> Contents:
    """The messages of the wanted channels."""
    found: list[tuple[int, int, int, int]] = []
    offset, size = 0, len(contents)
    while offset + _RECORD.size <= size:
        op, length = _RECORD.unpack_from(contents, offset)
        start = offset + _RECORD.size
        offset = start + length
        if offset > size:
            return contents, found, f"its last {size - start + _RECORD.size} bytes are no whole record"
        if op == MESSAGE:
            channel, _, log_time, _ = _MESSAGE.unpack_from(contents, start)
            if channel in wanted:
                found.append((log_time, start + _MESSAGE.size, offset, channel))
    return contents, found, f"its last {size - offset} bytes are no whole record" if offset < size else ""
