"""The maps of a run as an MCAP that viewers of robot data open."""

from pathlib import Path
from types import TracebackType
from typing import Any

from mcap.writer import CompressionType, Writer

from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.methods.intensity_map.messages import TOPICS, MapMessages

_CHUNK_BYTES = 4 << 20


class MapMcap:
    """Writes maps as ROS 2 messages; memory holds one chunk.

    The same maps give the same bytes. Use it as a context manager; leaving it without an error finishes the file.
    """

    def __init__(self, path: Path) -> None:
        self._file = path.open("wb")
        self._writer: Any = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._writer.start(profile="ros2", library="navtool")
        self._messages = MapMessages()
        self._channels: dict[str, int] = {}
        for topic, kind in TOPICS.items():
            schema = self._writer.register_schema(kind, "ros2msg", self._messages.definition(kind).encode())
            self._channels[topic] = self._writer.register_channel(topic, "cdr", schema)

    def add(self, mapped: MappedSweep, png: bytes | None) -> None:
        """Write a map's messages, the transform first; the picture where there is one."""
        transform = self._messages.transform(mapped)
        if transform is not None:
            self._write("/tf", mapped, transform)
        self._write("/intensity_map/classes", mapped, self._messages.classes(mapped))
        self._write("/intensity_map/plan", mapped, self._messages.plan(mapped))
        self._write("/intensity_map/layers", mapped, self._messages.layers(mapped))
        if png is not None:
            self._write("/intensity_map/picture", mapped, self._messages.picture(mapped, png))

    def _write(self, topic: str, mapped: MappedSweep, data: bytes) -> None:
        moment_ns = mapped.sweep.stamp_ns
        self._writer.add_message(self._channels[topic], moment_ns, data, moment_ns, mapped.number)

    def __enter__(self) -> "MapMcap":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is None:
            self._writer.finish()
        self._file.close()
