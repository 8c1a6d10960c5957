"""ROS 2 recordings in SQLite (``.db3``), every schema from the first (topics and messages only) to the newest.

Read with SQLite itself: the storage reader of rosbags builds an unescaped URI of the path, sorts whole messages where
the table has no index of times, and leaves out what a crashed recorder had not yet moved out of the write-ahead log.
"""

import logging
import shutil
import sqlite3
from collections.abc import Collection, Iterator
from itertools import islice
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.foreign import translated
from navtool.datasets.recording.message_compression import decompressed
from navtool.datasets.recording.raw import RawMessage
from navtool.datasets.recording.source import END_NS, Channel, Definition, normalised_type

_LOGGER = logging.getLogger(__name__)
_CURE = "if the recorder was killed or the copy is incomplete, try `sqlite3 FILE .recover` on a copy or copy it again"
_DEFINITION_FORMATS = {"ros2msg": "msg", "ros2idl": "idl"}
_WHOLE = "typeof(topic_id) = 'integer' AND typeof(timestamp) = 'integer' AND typeof(data) = 'blob' AND timestamp >= 0"
"""What a row is that a recorder wrote."""
_BY_KEY = "SELECT topic_id, timestamp, data FROM messages WHERE rowid = ?"
_HEAD_BY_KEY = "SELECT timestamp, topic_id FROM messages WHERE rowid = ?"
_MISSES = 20_000
"""So many rows in a row that cannot be read end the search for more."""
_LOGS = ("-wal", "-journal")


class Db3Source:
    """One ``.db3`` file; errors say where.

    Nothing is ever written beside it, not even SQLite's own ``-wal`` and ``-shm`` files.
    """

    def __init__(self, path: Path, *, where: Path) -> None:
        self._path = path
        self.where = where
        self._copy: TemporaryDirectory[str] | None = None
        self._damage = ""
        self._found: list[str] = []
        self._lost: set[int] = set()
        self._readable: list[tuple[int, int, int]] | None = None
        with translated("this db3 recording cannot be opened", where=where, cure=_CURE):
            self._database = self._connect()
        self._database.text_factory = _text
        try:
            with translated("this db3 recording cannot be read", where=where, cure=_CURE):
                self._read_index()
        except DatasetsError:
            self.close()
            raise

    @property
    def faults(self) -> tuple[str, ...]:
        """What is wrong with the file, as far as it was read; empty for a sound one."""
        lost = f"{len(self._lost)} messages skipped: they lie in damaged pages" if self._lost else ""
        return tuple(fault for fault in (self._damage, *self._found, lost) if fault)

    def messages(self, topics: Collection[str], start_ns: int = 0, end_ns: int = END_NS) -> Iterator[RawMessage]:
        """The messages of the topics within the times, in the order of their record times."""
        with translated("this db3 recording is damaged", where=self.where, cure=_CURE):
            wanted = {key: (c.topic, c.type) for key, c in self._channel_of.items() if c.topic in topics and c.count}
            for topic_id, record_ns, data in self._whole_rows(tuple(wanted), start_ns, end_ns):
                yield RawMessage(*wanted[topic_id], record_ns, decompressed(data))

    def close(self) -> None:
        """Let go of the file, and of its copy where there was need for one."""
        self._database.close()
        if self._copy is not None:
            self._copy.cleanup()

    def _connect(self) -> sqlite3.Connection:
        # SQLite looks for its logs beside the file itself, not beside a link to it.
        file = self._path.resolve()
        logs = [log for suffix in _LOGS if (log := Path(f"{file}{suffix}")).is_file() and log.stat().st_size]
        if not logs:
            return sqlite3.connect(f"{file.as_uri()}?mode=ro&immutable=1", uri=True)
        # Only SQLite can apply what the logs hold, and it needs to write for that.
        self._copy = TemporaryDirectory(prefix="navtool-db3-")
        _LOGGER.info("%s was not closed by its recorder: reading a copy of it in %s", self.where, self._copy.name)
        for part in (file, *logs):
            shutil.copy(part, self._copy.name)
        return sqlite3.connect(Path(self._copy.name, file.name))

    def _admit_damage(self) -> None:
        """Have SQLite read a file that is shorter than its header says, which it refuses otherwise."""
        try:
            self._database.execute("SELECT COUNT(*) FROM sqlite_master").fetchone()
        except sqlite3.DatabaseError as error:
            self._database.execute("PRAGMA writable_schema = ON")
            self._damage = f"damaged ({error})"

    def _read_index(self) -> None:
        self._admit_damage()
        tables = {name for (name,) in self._database.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
        if missing := {"topics", "messages"} - tables:
            raise DatasetsError(
                f"an SQLite database without the table {' and '.join(sorted(missing))}",
                cure="pass a database that `ros2 bag record` wrote",
            )
        definitions: dict[str, Definition] = {}
        if "message_definitions" in tables:
            definitions = {
                name: Definition(_DEFINITION_FORMATS.get(encoding, encoding), text)
                for name, encoding, text in self._readable_rows(
                    "SELECT topic_type, encoding, encoded_message_definition FROM message_definitions",
                    (str, str, str),
                    "message definitions",
                )
                if text
            }
        counts = self._counts()
        topics = self._readable_rows(
            "SELECT id, name, type, serialization_format FROM topics", (int, str, str, str), "topics"
        )
        self._channel_of = {
            key: Channel(name, normalised_type(kind), encoding, definitions.get(kind), counts.get(key, (0,))[0])
            for key, name, kind, encoding in sorted(topics)
        }
        if lost := sum(count for key, (count, _, _) in counts.items() if key not in self._channel_of):
            self._found.append(f"{lost} messages skipped: the rows that name their topic are lost")
        spans = [(first, last) for key, (_, first, last) in counts.items() if key in self._channel_of]
        self.channels = tuple(self._channel_of.values())
        self.span_ns = (min(first for first, _ in spans), max(last for _, last in spans)) if spans else None
        self._indexed = any(
            columns[0][2] == "timestamp"
            for (name,) in self._database.execute(
                "SELECT name FROM sqlite_master WHERE type = 'index' AND tbl_name = 'messages'"
            ).fetchall()
            if (columns := self._database.execute("SELECT * FROM pragma_index_info(?)", (name,)).fetchall())
        )

    def _readable_rows(self, query: str, kinds: tuple[type, ...], what: str) -> list[tuple[Any, ...]]:
        """The rows of a small table with values of these kinds, up to the first that cannot be read."""
        found: list[tuple[Any, ...]] = []
        odd = 0
        try:
            for row in self._database.execute(query):
                if all(isinstance(value, kind) for value, kind in zip(row, kinds, strict=True)):
                    found.append(row)
                else:
                    odd += 1
        except sqlite3.DatabaseError as error:
            self._found.append(f"only {len(found)} {what} can be read ({error})")
        if odd:
            self._found.append(f"{odd} {what} skipped: their rows hold values of other kinds")
        return found

    def _counts(self) -> dict[int, tuple[int, int, int]]:
        """Number, first and last record time of each topic's messages."""
        query = (
            f"SELECT topic_id, COUNT(*), MIN(timestamp), MAX(timestamp) FROM messages WHERE {_WHOLE} GROUP BY topic_id"  # noqa: S608 - a constant
        )
        try:
            counts = {key: (count, first, last) for key, count, first, last in self._database.execute(query)}
            (rows,) = self._database.execute("SELECT COUNT(*) FROM messages").fetchone()
        except sqlite3.DatabaseError as error:
            self._damage = f"damaged ({error}): read row by row"
        else:
            if odd := rows - sum(count for count, _, _ in counts.values()):
                if not counts:
                    raise DatasetsError(f"none of its {rows} rows is a message", cure=_CURE)
                self._found.append(f"{odd} messages skipped: their rows hold values of other kinds")
            return counts
        self._look_for_rows()
        if not self._readable:
            raise DatasetsError("not one of its messages can be read", cure=_CURE)
        counts = {}
        for record_ns, _, topic_id in self._readable:
            count, first, _ = counts.get(topic_id, (0, record_ns, record_ns))
            counts[topic_id] = (count + 1, first, record_ns)
        return counts

    def _whole_rows(self, topic_ids: tuple[int, ...], start_ns: int, end_ns: int) -> Iterator[tuple[int, int, bytes]]:
        """The rows; where one cannot be read, those behind it one by one."""
        done = 0
        try:
            for row in self._rows(topic_ids, start_ns, end_ns):
                yield row
                done += 1
        except sqlite3.DatabaseError as error:
            if self._readable is not None:
                raise
            self._damage = f"damaged ({error}): read row by row"
            self._look_for_rows()
            yield from islice(self._rows_one_by_one(topic_ids, start_ns, end_ns), done, None)

    def _rows(self, topic_ids: tuple[int, ...], start_ns: int, end_ns: int) -> Iterator[tuple[int, int, bytes]]:
        if self._readable is not None:
            return self._rows_one_by_one(topic_ids, start_ns, end_ns)
        marks = ", ".join("?" * len(topic_ids))
        if not self._indexed:
            return self._rows_in_order(topic_ids, marks, start_ns, end_ns)
        # The plus keeps SQLite on the index of times, which it walks without sorting.
        query = f"SELECT topic_id, timestamp, data FROM messages WHERE +topic_id IN ({marks}) AND timestamp BETWEEN ? AND ? AND {_WHOLE} ORDER BY timestamp, rowid"  # noqa: S608, E501 - only constants
        return self._database.execute(query, (*topic_ids, start_ns, end_ns))

    def _rows_in_order(
        self, topic_ids: tuple[int, ...], marks: str, start_ns: int, end_ns: int
    ) -> Iterator[tuple[int, int, bytes]]:
        # Without an index SQLite would sort the messages themselves; their row numbers are enough.
        query = f"SELECT timestamp, rowid FROM messages WHERE topic_id IN ({marks}) AND timestamp BETWEEN ? AND ? AND {_WHOLE} ORDER BY timestamp, rowid"  # noqa: S608, E501 - only constants
        for _, key in self._database.execute(query, (*topic_ids, start_ns, end_ns)):
            yield self._database.execute(_BY_KEY, (key,)).fetchone()

    def _rows_one_by_one(
        self, topic_ids: tuple[int, ...], start_ns: int, end_ns: int
    ) -> Iterator[tuple[int, int, bytes]]:
        """What can be read of a damaged database."""
        for record_ns, key, topic_id in self._readable or ():
            if topic_id in topic_ids and start_ns <= record_ns <= end_ns:
                try:
                    row = self._database.execute(_BY_KEY, (key,)).fetchone()
                except sqlite3.DatabaseError:
                    self._lost.add(key)
                    continue
                if row is not None and isinstance(row[2], bytes):
                    yield row

    def _look_for_rows(self) -> None:
        """Ask for every row by its number: an index or a page that is damaged hides no other."""
        found: list[tuple[int, int, int]] = []
        missed, key = 0, 0
        while missed < _MISSES:
            key += 1
            try:
                row = self._database.execute(_HEAD_BY_KEY, (key,)).fetchone()
            except sqlite3.DatabaseError:
                row = None
            if row is None or not all(isinstance(value, int) for value in row) or row[0] < 0:
                missed += 1
                continue
            missed = 0
            found.append((row[0], key, row[1]))
        last = max((key for _, key, _ in found), default=0)
        self._lost |= set(range(1, last + 1)) - {key for _, key, _ in found}
        self._readable = sorted(found)


def _text(stored: bytes) -> str:
    """A text, whose damaged characters cost no more than themselves."""
    return stored.decode(errors="replace")
