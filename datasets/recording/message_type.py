"""Message types of a recording: from definitions to objects and header stamps, one type at a time and on demand."""

import struct
from functools import cache, lru_cache
from typing import Any, NamedTuple

from rosbags.interfaces import Nodetype
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.record_arrays import LIVOX_PACKAGES, RecordArrays, has_records
from navtool.datasets.recording.source import Definition, Read
from navtool.datasets.recording.standard_types import completed

_ENCODINGS = ("ros1", "cdr")
_HEADERS = ("std_msgs/msg/Header", "roslib/msg/Header")
_CDR_TIME = {b"\0\0": struct.Struct(">iI"), b"\0\1": struct.Struct("<iI")}
_DRIVERS_TYPES = {
    **{
        f"{package}/msg/CustomPoint": "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
        "uint8 reflectivity\nuint8 tag\nuint8 line"
        for package in LIVOX_PACKAGES
    },
    **{
        f"{package}/msg/CustomMsg": "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\n"
        f"uint8[3] rsvd\n{package}/CustomPoint[] points"
        for package in LIVOX_PACKAGES
    },
    **{
        f"{package}/msg/CompressedPointCloud2": "std_msgs/Header header\nuint32 height\nuint32 width\n"
        "sensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\nuint32 row_step\n"
        f"uint8[] compressed_data\nbool is_dense{more}"
        for package, more in (("point_cloud_interfaces", "\nstring format"), ("draco_point_cloud_transport", ""))
    },
    "ffmpeg_image_transport_msgs/msg/FFMPEGPacket": "std_msgs/Header header\nint32 width\nint32 height\n"
    "string encoding\nuint64 pts\nuint8 flags\nbool is_bigendian\nuint8[] data",
    "velodyne_msgs/msg/VelodynePacket": "builtin_interfaces/Time stamp\nuint8[1206] data",
    "velodyne_msgs/msg/VelodyneScan": "std_msgs/Header header\nvelodyne_msgs/VelodynePacket[] packets",
}
"""Types of sensor drivers that no ROS distribution holds, for recordings that embed no definitions."""
_IDL_SEPARATOR = "=" * 80 + "\n"


_CDR_PADDING = 3
"""Bytes that writers may append to a message."""
_MOST_LEFT = 64
"""Bytes behind a message's last field, as the recorder of a camera's SDK appends some; with more of them another
definition is at work."""

_SMALL_RECORD = 16
"""Larger records that are left at a message's end are some that its count lacks."""


class StampLayout(NamedTuple):
    """Where the header's stamp lies in a serialised message, behind the encapsulation that CDR starts with."""

    encoding: str
    offset: int
    framed: bool = False
    """Whether a frame's name follows, as it does in a header."""

    def stamp_ns(self, data: bytes) -> int:
        """The stamp in nanoseconds.

        Raises:
            KeyError: The encapsulation is unknown.
            struct.error: The message is shorter than its header.
        """
        if self.encoding == "ros1":
            sec, nsec = struct.unpack_from("<II", data, self.offset)
        else:
            sec, nsec = _CDR_TIME[data[:2]].unpack_from(data, 4 + self.offset)
        return int(sec) * 1_000_000_000 + int(nsec)

    def frame_id(self, data: bytes) -> str:
        """The frame's name; empty where there is none.

        Raises:
            struct.error: The message is shorter than its header.
            UnicodeDecodeError: It is no text.
        """
        if not self.framed:
            return ""
        place = self.offset + 8 if self.encoding == "ros1" else self.offset + 12
        big = self.encoding != "ros1" and data[1] == 0
        (size,) = struct.unpack_from(">I" if big else "<I", data, place)
        return data[place + 4 : place + 4 + size].rstrip(b"\0").decode()


class MessageType:
    """One message type by the definition of its channel, or by the default of the ROS distribution where it has none.

    Each type has its own store: two recorders may disagree about a type of the same name.

    Attributes:
        name: The type's name.
        encoding: How its messages are serialised.
        stamp_layout: Where the header's stamp lies; None where the type starts with neither header nor time.
        told: What was taken for a part of the definition that the recording lacks; empty where it is whole.
    """

    def __init__(
        self, name: str, encoding: str, definition: Definition | None, ros_distro: str, md5sum: str = ""
    ) -> None:
        """Read the definition down to its last part.

        Raises:
            DatasetsError: The encoding is not supported, or the definition is missing or not whole.
        """
        if encoding not in _ENCODINGS:
            raise DatasetsError(
                f"messages encoded as {encoding!r} are not supported yet; {' and '.join(_ENCODINGS)} are"
            )
        self.name = name
        self.encoding = encoding
        ros1 = encoding == "ros1"
        self.told = ""
        if definition is None:
            self._store = _default_types("ros1" if ros1 else ros_distro)
            if name not in self._store.fielddefs:
                raise DatasetsError(
                    f"the recording embeds no definition of {name}, and ROS {ros_distro} has no such type",
                    cure="record to MCAP, which embeds definitions, or convert it where the type is installed",
                )
        else:
            self._store = get_typestore(Stores.EMPTY)
            found = completed(_parsed, definition, name, md5sum, _default_types("ros1" if ros1 else ros_distro))
            self._store.register(found.types)
            self.told = found.told
        self._layout = self._layout_of(name, ())
        self.stamp_layout = self._stamp_layout()
        self._arrays = RecordArrays(self._store, name, encoding) if has_records(self._store, name) else None
        last_stride = 0 if self._arrays is None else self._arrays.last_stride
        self._most_left = min(_MOST_LEFT, last_stride - 1) if last_stride > _SMALL_RECORD else _MOST_LEFT
        self._fields: Any = self._store.get_msgdef(name)
        self._class = self._store.types[name]

    def layout(self) -> tuple[object, ...]:
        """The fields with their types, down to the basic ones: equal layouts read equal bytes equally."""
        return self._layout

    def deserialise(self, data: bytes) -> Any:
        """The message as an object with the definition's fields; its arrays are views of the data.

        A sequence of one of the `RECORD_TYPES` is a structured array.
        """
        return self.read(data).message

    def read(self, data: bytes) -> Read:
        """The message, and how many bytes are left behind its last field.

        Raises:
            DatasetsError: There are fewer bytes than its content needs, or many more.
        """
        content = memoryview(data)
        if self._arrays is not None:
            message, end = self._arrays.read(content)
        elif self.encoding == "ros1":
            message, end = self._fields.deserialize_ros1(content, 0, self._class, self._store)
        else:
            if data[:2] not in _CDR_TIME:
                raise DatasetsError("the message is in an unknown encapsulation")
            little = self._fields.deserialize_cdr_le, self._fields.deserialize_cdr_be
            message, end = little[data[1] == 0](content[4:], 0, self._class, self._store)
        size, padding = (len(data), 0) if self.encoding == "ros1" else (len(data) - 4, _CDR_PADDING)
        if not 0 <= size - end <= self._most_left:
            raise DatasetsError(f"a message of {size} bytes, whose content takes {end}")
        return Read(message, size - end if size - end > padding else 0)

    def _stamp_layout(self) -> StampLayout | None:
        fields = self._store.fielddefs[self.name][1]
        if fields and fields[0][1] == (Nodetype.NAME, "builtin_interfaces/msg/Time"):
            return StampLayout(self.encoding, 0)
        if not fields or fields[0][1][0] != Nodetype.NAME or fields[0][1][1] not in _HEADERS:
            return None
        header = [name for name, _ in self._store.fielddefs[str(fields[0][1][1])][1]]
        return StampLayout(self.encoding, 4 * header.index("stamp"), framed="frame_id" in header)

    def _layout_of(self, name: str, within: tuple[str, ...]) -> tuple[object, ...]:
        if name not in self._store.fielddefs:
            raise DatasetsError(f"its definition cannot be read: it lacks that of {name}")
        if name in within:
            raise DatasetsError(f"its definition cannot be read: {name} has itself within")
        fields = self._store.fielddefs[name][1]
        return tuple((field, self._description(kind, (*within, name))) for field, kind in fields)

    def _description(self, kind: Any, within: tuple[str, ...]) -> object:
        if kind[0] == Nodetype.NAME:
            return self._layout_of(kind[1], within)
        if kind[0] == Nodetype.BASE:
            return kind[1]
        return (int(kind[0]), self._description(kind[1][0], within), kind[1][1])


@lru_cache(maxsize=512)
def message_type(
    name: str, encoding: str, definition: Definition | None, ros_distro: str, md5sum: str = ""
) -> MessageType:
    """The type, made once for all recordings that define it alike: making it takes about 20 ms.

    Raises:
        DatasetsError: Its encoding is not supported, or there is no definition of it.
    """
    return MessageType(name, encoding, definition, ros_distro, md5sum)


def check_ros_distro(ros_distro: str) -> None:
    """Do nothing where the name is that of a ROS 2 distribution whose types are known.

    Raises:
        DatasetsError: It is not.
    """
    known = sorted(x.value.removeprefix("ros2_") for x in Stores if x.value.startswith("ros2_"))
    if ros_distro not in known:
        raise DatasetsError(f"unknown ROS 2 distribution {ros_distro!r}", cure=f"use one of {', '.join(known)}")


@cache
def _default_types(ros_distro: str) -> Typestore:
    store = get_typestore(Stores.ROS1_NOETIC if ros_distro == "ros1" else Stores(f"ros2_{ros_distro}"))
    for name, text in _DRIVERS_TYPES.items():
        store.register(get_types_from_msg(text, name))
    return store


def _parsed(definition: Definition, name: str) -> Any:
    if definition.format == "msg":
        return get_types_from_msg(definition.text, name)
    if definition.format != "idl":
        raise DatasetsError(f"definitions written in {definition.format!r} are not supported yet; msg and idl are")
    if not definition.text.startswith(_IDL_SEPARATOR):
        return get_types_from_idl(definition.text)
    types: dict[str, Any] = {}
    for part in definition.text.split(_IDL_SEPARATOR)[1:]:
        types.update(get_types_from_idl(part.partition("\n")[2]))
    return types
