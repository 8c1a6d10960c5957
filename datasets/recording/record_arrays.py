"""Messages with tens of thousands of small records, such as a cloud's points: each sequence of them is one array.

The library that reads messages makes an object of every record; an array is a view of the message's bytes.
"""

import struct
from typing import Any, Literal, NamedTuple

import numpy as np
from jaxtyping import Shaped
from rosbags.interfaces import Nodetype
from rosbags.typesys.store import Typestore

from navtool.base.errors import DatasetsError
from navtool.pipeline.arrays import Array

LIVOX_PACKAGES = ("livox_ros_driver", "livox_ros_driver2", "livox_interfaces")
RECORD_TYPES = frozenset(
    {
        "geometry_msgs/msg/Point32",
        "velodyne_msgs/msg/VelodynePacket",
        *(f"{package}/msg/CustomPoint" for package in LIVOX_PACKAGES),
    }
)
"""Types whose sequences are read as structured arrays, their fields by name."""

_CODES = {
    "bool": "?",
    "byte": "i1",
    "char": "u1",
    "int8": "i1",
    "int16": "i2",
    "int32": "i4",
    "int64": "i8",
    "uint8": "u1",
    "uint16": "u2",
    "uint32": "u4",
    "uint64": "u8",
    "float32": "f4",
    "float64": "f8",
}
type _Order = Literal["<", ">"]
_CDR_ORDERS: dict[bytes, _Order] = {b"\0\0": ">", b"\0\1": "<"}


class _Records(NamedTuple):
    """How the records of a sequence lie in the bytes: their number, then one after the other, padding in between."""

    field: str
    alignment: int
    dtype: np.dtype[np.void]
    first_alignment: int
    stride: int

    def read(self, data: memoryview, offset: int, order: _Order) -> tuple[Shaped[Array, " n"], int]:
        """The records of a sequence that begins at the offset, and the offset behind them."""
        (count,) = struct.unpack_from(f"{order}I", data, offset)
        if not count:
            return np.empty(0, self.dtype), offset + 4
        start = _aligned(offset + 4, self.first_alignment)
        end = start + (count - 1) * self.stride + self.dtype.itemsize
        if end > len(data):
            raise DatasetsError(
                f"truncated message: {count} records of {self.field} end at byte {end}, but it has {len(data)}"
            )
        dtype = self.dtype.newbyteorder(order)
        return np.ndarray((count,), dtype, buffer=data, offset=start, strides=(self.stride,)), end


class _Others(NamedTuple):
    """Fields in a row that are no sequences of records, as a type of their own."""

    name: str
    alignment: int


def has_records(store: Typestore, name: str) -> bool:
    """Whether sequences of `RECORD_TYPES` are among the fields of a type."""
    return any(_record_of(kind) is not None for _, kind in store.fielddefs[name][1])


class RecordArrays:
    """Reads the messages of a type that has sequences of `RECORD_TYPES` among its fields.

    The message is the same object as otherwise, but for those fields. They are read in either byte order.

    Raises:
        DatasetsError: A record has fields that are no plain numbers, or records do not all lie alike.
    """

    def __init__(self, store: Typestore, name: str, encoding: str) -> None:
        self._store, self._name, self._cdr = store, name, encoding == "cdr"
        self._steps: list[_Records | _Others] = []
        others: list[Any] = []
        for field, kind in store.fielddefs[name][1]:
            record = _record_of(kind)
            if record is None:
                others.append((field, kind))
                continue
            self._add_others(others)
            self._steps.append(self._records(field, record))
            others = []
        self._add_others(others)

    @property
    def last_stride(self) -> int:
        """Bytes of a record of the sequence at the message's end, 0 for none; fewer than that can be left behind it."""
        last = self._steps[-1]
        return last.stride if isinstance(last, _Records) else 0

    def read(self, data: memoryview) -> tuple[Any, int]:
        """The message, and the offset behind its last field in the bytes behind the encapsulation.

        Raises:
            DatasetsError: There are fewer bytes than its content needs.
        """
        order: _Order = "<"
        if self._cdr:
            start = bytes(data[:2])
            if start not in _CDR_ORDERS:
                raise DatasetsError("the message is in an unknown encapsulation")
            order, data = _CDR_ORDERS[start], data[4:]
        values: list[Any] = []
        offset = 0
        for step in self._steps:
            offset = _aligned(offset, step.alignment)
            if isinstance(step, _Records):
                array, offset = step.read(data, offset, order)
                values.append(array)
            else:
                kind = self._store.get_msgdef(step.name)
                read: Any = kind.deserialize_ros1
                if self._cdr:
                    read = kind.deserialize_cdr_le if order == "<" else kind.deserialize_cdr_be
                others, offset = read(data, offset, _tuple, self._store)
                values += others
        return self._store.types[self._name](*values), offset

    def _add_others(self, fields: list[Any]) -> None:
        if fields:
            name = f"{self._name}Part{len(self._steps)}"
            self._store.register({name: ([], fields)})
            self._steps.append(_Others(name, self._alignment(fields[0][1])))

    def _records(self, field: str, record: str) -> _Records:
        sizes: list[int] = []
        dtype = self._dtype(field, record, 0, sizes)
        # CDR aligns numbers, not records: they all lie alike where the first number is the one to be aligned most.
        first = sizes[0] if self._cdr else 1
        if self._cdr and max(sizes) > first:
            raise DatasetsError(f"{field} has records of {record} that do not all lie alike in the message")
        return _Records(field, 4 if self._cdr else 1, dtype, first, _aligned(dtype.itemsize, first))

    def _dtype(self, field: str, record: str, start: int, sizes: list[int]) -> np.dtype[np.void]:
        """How a record lies in the bytes that begins at this offset of an outer one; its numbers' sizes are added."""
        names, kinds, offsets = [], [], []
        end = start
        for name, (node, what) in self._store.fielddefs[record][1]:
            base = what[0] if node == Nodetype.ARRAY and what[0][0] == Nodetype.BASE else (node, what)
            kind: np.dtype[Any]
            if base[0] == Nodetype.NAME:
                # A record within begins where its first number may lie.
                offset = _aligned(end, self._alignment(base))
                kind = self._dtype(field, str(base[1]), offset, sizes)
            elif base[0] == Nodetype.BASE and base[1][0] in _CODES:
                number = np.dtype(_CODES[str(base[1][0])])
                offset = _aligned(end, number.itemsize if self._cdr else 1)
                kind = np.dtype((number, (what[1],))) if node == Nodetype.ARRAY else number
                sizes.append(number.itemsize)
            else:
                raise DatasetsError(f"{field} has records of {record}, whose {name} is no plain number")
            names.append(name)
            kinds.append(kind)
            offsets.append(offset - start)
            end = offset + kind.itemsize
        return np.dtype({"names": names, "formats": kinds, "offsets": offsets, "itemsize": end - start})

    def _alignment(self, kind: Any) -> int:
        """The number of bytes of which such a field's offset is a multiple."""
        node, what = kind
        if not self._cdr:
            return 1
        if node == Nodetype.NAME:
            return self._alignment(self._store.fielddefs[what][1][0][1])
        if node == Nodetype.ARRAY:
            return self._alignment(what[0])
        return np.dtype(_CODES[what[0]]).itemsize if node == Nodetype.BASE and what[0] != "string" else 4


def _record_of(kind: Any) -> str | None:
    """The type of the records where the field is a sequence of them."""
    if kind[0] == Nodetype.SEQUENCE and kind[1][0][0] == Nodetype.NAME and kind[1][0][1] in RECORD_TYPES:
        return str(kind[1][0][1])
    return None


def _aligned(offset: int, alignment: int) -> int:
    return offset + -offset % alignment


def _tuple(*values: Any) -> tuple[Any, ...]:
    return values
