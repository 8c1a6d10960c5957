"""ROS 1 bags, version 2.0, chunks uncompressed or bz2 or lz4, whole or damaged."""

from collections import Counter
from collections.abc import Collection, Container, Iterator
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import ros1_bag as bag
from navtool.datasets.recording.chunks import Chunk, Contents, Skipped, merged
from navtool.datasets.recording.file_bytes import FileBytes
from navtool.datasets.recording.foreign import describe, translated
from navtool.datasets.recording.raw import RawMessage
from navtool.datasets.recording.source import END_NS, Channel, Definition, normalised_type

_CURE = "copy it again from where it was recorded"


class Ros1Source:
    """One ``.bag`` file, read chunk by chunk; errors say where.

    The index at its end says what each chunk holds. Where there is none, because the recorder was stopped or the copy
    is incomplete, or where it does not fit the file, every chunk is looked into once, in the order of the file, up to
    where it ends; whatever cannot be read is skipped and named in ``faults``.
    """

    def __init__(self, path: Path, *, where: Path) -> None:
        self.where = where
        self._found: list[str] = []
        self._connections: dict[int, bag.Connection] = {}
        self._records: dict[int, bag.Record] = {}
        self._counts: Counter[int] = Counter()
        with translated("this ROS 1 bag cannot be read", where=where, cure=_CURE):
            self._content = FileBytes(path)
        try:
            with translated("this ROS 1 bag cannot be read", where=where, cure=_CURE):
                self._check_version()
                chunks = self._by_index() or self._by_looking()
                if not self._counts and self._found:
                    raise DatasetsError(f"nothing in it can be read: {'; '.join(self._found)}", cure=_CURE)
        except DatasetsError:
            self.close()
            raise
        if lost := sum(count for key, count in self._counts.items() if key not in self._connections):
            self._found.append(f"{lost} messages skipped: the records that name their topic are lost")
        self._chunks = chunks
        self._skipped = Skipped(len(chunks))
        self._channel_of = {
            key: Channel(
                c.topic,
                normalised_type(c.type),
                "ros1",
                Definition("msg", c.definition) if c.definition else None,
                self._counts[key],
                c.md5sum,
            )
            for key, c in self._connections.items()
        }
        self.channels = tuple(self._channel_of.values())
        spans = [(chunk.start_ns, chunk.end_ns) for chunk in chunks if chunk.channels]
        self.span_ns = (min(first for first, _ in spans), max(last for _, last in spans)) if spans else None

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with the file, as far as it was read; empty for a sound one."""
        return (*self._found, *self._skipped.faults())

    def messages(self, topics: Collection[str], start_ns: int = 0, end_ns: int = END_NS) -> Iterator[RawMessage]:
        """The messages of the topics within the times, in the order of their record times."""
        wanted = {key: (c.topic, c.type) for key, c in self._channel_of.items() if c.topic in topics and c.count}
        with translated("this ROS 1 bag is damaged", where=self.where, cure=_CURE):
            for message in merged(self._chunks, wanted, self._load, self._skipped, start_ns, end_ns):
                publisher = self._connections[message.channel].publisher
                yield RawMessage(*wanted[message.channel], message.record_ns, message.data, publisher)

    def close(self) -> None:
        """Let go of the file."""
        self._content.close()

    def _load(self, chunk: Chunk, wanted: Container[int]) -> Contents:
        record = self._records[chunk.offset]
        contents = bag.chunk_contents(self._content, record)
        _, found, lacking = bag.messages_in(contents, wanted)
        announced = bag.number(record, b"size")
        if not lacking and len(contents) < announced:
            lacking = f"{len(contents)} bytes where {announced} are announced"
        return contents, found, lacking

    def _check_version(self) -> None:
        head = self._content[: len(bag.MAGIC)]
        if head != bag.MAGIC:
            version = head.decode(errors="replace").removeprefix("#ROSBAG V").strip()
            raise DatasetsError(
                f"bags of version {version} are not supported; 2.0 is", cure="run `rosbag migrate` on it"
            )

    def _by_index(self) -> list[Chunk]:
        """The chunks as the index at the file's end lists them; none where it is missing or does not fit the file."""
        try:
            chunks = self._read_index()
        except Exception as error:
            what = str(error) if isinstance(error, ValueError | DatasetsError) else describe(error)
            self._found.append(f"no usable index ({what}): read in the order of the file")
            self._connections.clear()
            self._records.clear()
            self._counts.clear()
            return []
        return chunks

    def _read_index(self) -> list[Chunk]:
        size = len(self._content)
        head = bag.record_at(self._content, len(bag.MAGIC), size)
        if head.op != bag.HEADER:
            raise ValueError("the file does not begin with a bag header")
        offset = bag.number(head, b"index_pos")
        if offset == 0:
            raise ValueError("the recorder did not close it")
        if head.fields.get(b"encryptor"):
            raise DatasetsError("an encrypted bag", cure="decrypt it first")
        chunks = []
        while offset < size:
            record = bag.record_at(self._content, offset, size)
            if record.end > size:
                raise ValueError("it is cut off")
            if record.op == bag.CONNECTION:
                self._connections[bag.number(record, b"conn")] = bag.connection_of(self._content, record)
            elif record.op == bag.CHUNK_INFO:
                chunks.append(self._listed(record))
            offset = record.end
        wanted = bag.number(head, b"chunk_count"), bag.number(head, b"conn_count")
        if (len(chunks), len(self._connections)) != wanted:
            raise ValueError(f"it lists {len(chunks)} chunks of {wanted[0]}")
        return chunks

    def _listed(self, info: bag.Record) -> Chunk:
        offset = bag.number(info, b"chunk_pos")
        record = bag.record_at(self._content, offset, len(self._content))
        if record.op != bag.CHUNK or not bag.readable(record):
            raise ValueError(f"there is no chunk that can be read at byte {offset}")
        self._records[offset] = record
        data = self._content[info.start : info.end]
        channels = set()
        for at in range(0, len(data) - 7, 8):
            connection = int.from_bytes(data[at : at + 4], "little")
            channels.add(connection)
            self._counts[connection] += int.from_bytes(data[at + 4 : at + 8], "little")
        start_ns, end_ns = (bag.time_ns(info.fields[name]) for name in (b"start_time", b"end_time"))
        return Chunk(offset, record.end - offset, start_ns, end_ns, frozenset(channels), bag.packed(record))

    def _by_looking(self) -> list[Chunk]:
        """The chunks in the order of the file, each looked into."""
        size = len(self._content)
        offset: int | None = len(bag.MAGIC)
        chunks: list[Chunk] = []
        unread = 0
        while offset is not None and offset < size:
            try:
                record = bag.record_at(self._content, offset, size)
                chunk = self._looked_into(record) if record.op == bag.CHUNK else None
            except ValueError:
                following = bag.next_chunk(self._content, offset + 1)
                unread += (size if following is None else following) - offset
                offset = following
                continue
            except Exception as error:
                self._found.append(f"the chunk at byte {offset} cannot be read ({error})")
                chunk = None
            if chunk is not None:
                chunks.append(chunk)
            if record.end > size:
                self._found.append(f"cut off after {size / 1e6:.3f} MB, within a record of {record.end - offset} bytes")
            offset = record.end
        if unread:
            self._found.append(f"{unread / 1e6:.6f} MB between readable records skipped")
        return chunks

    def _looked_into(self, record: bag.Record) -> Chunk | None:
        contents = bag.chunk_contents(self._content, record)
        times, channels = [], set()
        for inner in bag.records_in(contents):
            if inner.op == bag.CONNECTION:
                self._connections[bag.number(inner, b"conn")] = bag.connection_of(contents, inner)
            elif inner.op == bag.MESSAGE:
                connection = bag.number(inner, b"conn")
                times.append(bag.time_ns(inner.fields[b"time"]))
                channels.add(connection)
                self._counts[connection] += 1
        if not times:
            return None
        self._records[record.offset] = record
        size = record.end - record.offset
        return Chunk(record.offset, size, min(times), max(times), frozenset(channels), bag.packed(record))
