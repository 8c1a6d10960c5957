"""ROS 1 bags, version 2.0, chunks uncompressed or bz2 or lz4."""

from collections.abc import Collection, Iterator
from pathlib import Path

from rosbags.rosbag1 import Reader

from navtool.datasets.recording.foreign import translated
from navtool.datasets.recording.raw import RawMessage
from navtool.datasets.recording.source import Channel, Definition

_CURE = "if the recorder was stopped early or the copy is incomplete, run `rosbag reindex` on a copy or copy it again"


class Ros1Source:
    """One ``.bag`` file, read chunk by chunk; errors name the place."""

    def __init__(self, path: Path, *, where: Path) -> None:
        self._where = where
        with translated("this ROS 1 bag cannot be read", where=where, cure=_CURE):
            self._reader = Reader(path)
            self._reader.open()
            self.channels = tuple(
                Channel(
                    x.topic, x.msgtype, "ros1", Definition("msg", x.msgdef.data) if x.msgdef.data else None, x.msgcount
                )
                for x in self._reader.connections
            )
            counted = self._reader.message_count > 0
            # rosbags puts the end behind the last message.
            self.span_ns = (self._reader.start_time, self._reader.end_time - 1) if counted else None

    def messages(self, topics: Collection[str]) -> Iterator[RawMessage]:
        """The messages of the topics in the order of their record times."""
        with translated("this ROS 1 bag is damaged", where=self._where, cure=_CURE):
            wanted = [x for x in self._reader.connections if x.topic in topics and x.msgcount]
            if not wanted:
                return
            for connection, record_ns, data in self._reader.messages(wanted):
                yield RawMessage(connection.topic, connection.msgtype, record_ns, data)

    def close(self) -> None:
        """Let go of the file."""
        if self._reader.bio is not None:
            self._reader.close()
