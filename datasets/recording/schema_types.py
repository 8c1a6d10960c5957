"""Message types of schema languages other than ROS's: JSON and protobuf, as Foxglove's tools record them.

Nothing of a recording is executed: protobuf's classes are built from the descriptors in the file, JSON is data.
"""

import base64
import json
from types import SimpleNamespace
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.header import joined_ns
from navtool.datasets.recording.source import Definition, Read

_BINARY = ("data",)
"""Fields that hold bytes; JSON has them in base64."""


class JsonType:
    """Messages that are JSON objects; they come as namespaces.

    Attributes:
        name: The type's name.
        encoding: ``json``.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.encoding = "json"

    told = ""
    """Nothing was done about its definition."""

    @property
    def stamp_layout(self) -> "JsonType":
        """What reads the stamp: the message itself."""
        return self

    def layout(self) -> tuple[object, ...]:
        """JSON describes itself."""
        return ("json", self.name)

    def deserialise(self, data: bytes) -> Any:
        """The object; fields named ``data`` decoded from base64."""
        return json.loads(data, object_hook=_namespace)

    def read(self, data: bytes) -> Read:
        """The object, whole or not at all."""
        return Read(self.deserialise(data))

    def stamp_ns(self, data: bytes) -> int | None:
        """The stamp in nanoseconds; None where the message has none."""
        time = json.loads(data).get("timestamp")
        return None if time is None else joined_ns(time["sec"], time["nsec"])


class ProtobufType:
    """Messages of protobuf, by the descriptors that the recording embeds.

    Attributes:
        name: The type's name.
        encoding: ``protobuf``.
    """

    def __init__(self, name: str, definition: Definition) -> None:
        from google.protobuf import descriptor_pb2, descriptor_pool, message_factory  # noqa: PLC0415 - takes 40 ms

        self.name = name
        self.encoding = "protobuf"
        self._text = definition.text
        pool = descriptor_pool.DescriptorPool()
        files = descriptor_pb2.FileDescriptorSet.FromString(definition.text.encode("latin-1"))
        for file in _in_order(list(files.file)):
            pool.Add(file)
        self._class = message_factory.GetMessageClass(pool.FindMessageTypeByName(name))

    told = ""
    """Nothing was done about its definition."""

    @property
    def stamp_layout(self) -> "ProtobufType":
        """What reads the stamp: the message itself."""
        return self

    def layout(self) -> tuple[object, ...]:
        """Equal descriptors read equal bytes equally."""
        return ("protobuf", self.name, self._text)

    def deserialise(self, data: bytes) -> Any:
        """The message."""
        return self._class.FromString(bytes(data))

    def read(self, data: bytes) -> Read:
        """The message, whole or not at all."""
        return Read(self.deserialise(data))

    def stamp_ns(self, data: bytes) -> int | None:
        """The stamp in nanoseconds; None where the message has none."""
        time = getattr(self.deserialise(data), "timestamp", None)
        return None if time is None else joined_ns(time.seconds, time.nanos)


def schema_type(name: str, encoding: str, definition: Definition | None) -> JsonType | ProtobufType:
    """The type of a channel that is encoded as JSON or protobuf.

    Raises:
        DatasetsError: A protobuf channel has no descriptors.
    """
    if encoding == "json":
        return JsonType(name)
    if definition is None or definition.format != "protobuf":
        raise DatasetsError(f"the recording embeds no protobuf descriptors of {name}", cure="record it with its schema")
    return ProtobufType(name, definition)


def _namespace(fields: dict[str, Any]) -> SimpleNamespace:
    for name in _BINARY:
        if isinstance(fields.get(name), str):
            fields[name] = base64.b64decode(fields[name], validate=True)
    return SimpleNamespace(**fields)


def _in_order(files: list[Any]) -> list[Any]:
    """Files behind those that they import; imports that the set lacks are left to the pool to complain of."""
    by_name = {file.name: file for file in files}
    ordered: dict[str, Any] = {}

    def visit(name: str, under_way: frozenset[str]) -> None:
        if name in ordered or name in under_way or name not in by_name:
            return
        for needed in by_name[name].dependency:
            visit(needed, under_way | {name})
        ordered[name] = by_name[name]

    for file in files:
        visit(file.name, frozenset())
    return list(ordered.values())
