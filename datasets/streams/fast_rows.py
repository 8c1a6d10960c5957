"""Rows straight from the bytes, for the messages that come hundreds of times a second.

Only for messages whose definition is the usual one and whose size is exactly what it asks for; for all others, and
where anything is odd, the decoders have the word. Both give the same rows: this is a matter of speed alone.
"""

import struct
from collections.abc import Callable

from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.streams.rows import IMU_COLUMNS, ODOMETRY_COLUMNS, StreamRows, joint_columns
from navtool.datasets.streams.table import TWIST_COLUMNS
from navtool.datasets.streams.usual_layout import usual_layout

_U32 = struct.Struct("<I")
_ROS1_HEAD = struct.Struct("<IIII")
_CDR_HEAD = struct.Struct("<iII")
_LITTLE = b"\x00\x01"
_IMU = struct.Struct("<104x3d72x3d72x")
"""Attitude and its covariance, turn rates and theirs, accelerations and theirs."""
_ODOMETRY = struct.Struct("<7d288x6d288x")
"""Pose and its covariance, velocity and its."""
_TWIST = struct.Struct("<6d")

type FastRow = Callable[[bytes], StreamRows | None]


class FastRows:
    """Reads rows of one recording; what it has no way with it leaves to the decoders."""

    def __init__(self, recording: Recording) -> None:
        self._recording = recording
        self._readers: dict[tuple[str, str], FastRow | None] = {}

    def row(self, raw: RawMessage) -> StreamRows | None:
        """The row of a message; None where the decoders must say."""
        key = (raw.topic, raw.type)
        if key not in self._readers:
            self._readers[key] = self._reader(raw)
        reader = self._readers[key]
        if reader is None:
            return None
        try:
            return reader(raw.data)
        except (struct.error, UnicodeDecodeError):
            return None

    def _reader(self, raw: RawMessage) -> FastRow | None:
        make = _READERS.get(raw.type)
        described = self._recording.layout_of(raw)
        if make is None or described is None:
            return None
        encoding, layout = described
        return make(_Bytes(encoding)) if layout == usual_layout(raw.type, encoding) else None


class _Bytes:
    """The serialisation: where things lie in a message."""

    def __init__(self, encoding: str) -> None:
        self.ros1 = encoding == "ros1"

    def head(self, data: bytes) -> tuple[int, str, int] | None:
        """Stamp, frame and the place behind the header; None for another byte order."""
        if self.ros1:
            _, seconds, rest, size = _ROS1_HEAD.unpack_from(data)
            return seconds * 1_000_000_000 + rest, data[16 : 16 + size].decode(), 16 + size
        if data[:2] != _LITTLE:
            return None
        seconds, rest, size = _CDR_HEAD.unpack_from(data, 4)
        return seconds * 1_000_000_000 + rest, data[16 : 16 + size - 1].decode(), 16 + size

    def doubles(self, place: int) -> int:
        """Where doubles begin that come at a place."""
        return place if self.ros1 else place + (4 - place) % 8

    def words(self, place: int) -> int:
        """Where a 32-bit number begins that comes at a place."""
        return place if self.ros1 else place + -place % 4

    def text(self, data: bytes, place: int) -> tuple[str, int]:
        """A string, and the place behind it."""
        place = self.words(place)
        size = _U32.unpack_from(data, place)[0]
        end = place + 4 + size
        return data[place + 4 : end if self.ros1 else end - 1].decode(), end


def _imu(serial: _Bytes) -> FastRow:
    def read(data: bytes) -> StreamRows | None:
        head = serial.head(data)
        if head is None:
            return None
        stamp, frame, place = head
        place = serial.doubles(place)
        if len(data) != place + _IMU.size:
            return None
        wx, wy, wz, ax, ay, az = _IMU.unpack_from(data, place)
        return StreamRows(stamp, frame, IMU_COLUMNS, (ax, ay, az, wx, wy, wz))

    return read


def _odometry(serial: _Bytes) -> FastRow:
    def read(data: bytes) -> StreamRows | None:
        head = serial.head(data)
        if head is None:
            return None
        stamp, parent, place = head
        child, place = serial.text(data, place)
        place = serial.doubles(place)
        if len(data) != place + _ODOMETRY.size:
            return None
        return StreamRows(stamp, child, ODOMETRY_COLUMNS, _ODOMETRY.unpack_from(data, place), parent=parent)

    return read


def _twist(serial: _Bytes) -> FastRow:
    def read(data: bytes) -> StreamRows | None:
        head = serial.head(data)
        if head is None:
            return None
        stamp, frame, place = head
        place = serial.doubles(place)
        if len(data) != place + _TWIST.size:
            return None
        return StreamRows(stamp, frame, TWIST_COLUMNS, _TWIST.unpack_from(data, place))

    return read


def _joints(serial: _Bytes) -> FastRow:
    names: tuple[str, ...] = ()
    block = b""  # the names as they lie in the messages: the same in every one

    def read(data: bytes) -> StreamRows | None:
        nonlocal names, block
        head = serial.head(data)
        if head is None:
            return None
        stamp, frame, place = head
        place = serial.words(place)
        if not block or data[place : place + len(block)] != block:
            names, block = _names(serial, data, place)
        place += len(block)
        values: tuple[float, ...] = ()
        for _ in range(3):
            place = serial.words(place)
            if _U32.unpack_from(data, place)[0] != len(names):
                return None
            place = serial.doubles(place + 4)
            values += struct.unpack_from(f"<{len(names)}d", data, place)
            place += 8 * len(names)
        if len(data) != place or not names:
            return None
        return StreamRows(stamp, frame, joint_columns(names), values, names)

    return read


def _names(serial: _Bytes, data: bytes, place: int) -> tuple[tuple[str, ...], bytes]:
    count = _U32.unpack_from(data, place)[0]
    if count > len(data):
        raise struct.error("more names than bytes")
    at, names = place + 4, []
    for _ in range(count):
        name, at = serial.text(data, at)
        names.append(name)
    return tuple(names), data[place:at]


_READERS: dict[str, Callable[[_Bytes], FastRow]] = {
    "geometry_msgs/msg/TwistStamped": _twist,
    "nav_msgs/msg/Odometry": _odometry,
    "sensor_msgs/msg/Imu": _imu,
    "sensor_msgs/msg/JointState": _joints,
}
