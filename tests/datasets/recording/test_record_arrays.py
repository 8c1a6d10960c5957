"""Sequences of records as arrays: what the library reads record by record, in both serialisations and byte orders."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.message_type import MessageType
from navtool.datasets.recording.source import Definition

MESSAGE, POINT = "livox_ros_driver2/msg/CustomMsg", "livox_ros_driver2/msg/CustomPoint"
SIZES = {"uint8": 1, "int8": 1, "char": 1, "bool": 1, "int16": 2, "uint16": 2, "float32": 4, "int32": 4, "float64": 8}
OTHERS = ("uint8", "float64", "string", "uint8[3]", "int16[]", "geometry_msgs/Point", "std_msgs/Header", "string[]")


class Layout(NamedTuple):
    point: tuple[str, ...]
    """The records' numbers."""
    before: tuple[str, ...]
    after: tuple[str, ...]
    records: int
    seed: int


def layouts(first_is_widest: bool) -> st.SearchStrategy[Layout]:
    """Records of any numbers among any other fields."""
    numbers = st.lists(st.sampled_from(sorted(SIZES)), min_size=1, max_size=5)
    others = st.lists(st.sampled_from(OTHERS), max_size=3)
    made = st.builds(
        lambda *x: Layout(tuple(x[0]), tuple(x[1]), tuple(x[2]), x[3], x[4]),
        *(numbers, others, others, st.integers(0, 4), st.integers(0, 99)),
    )
    return made.filter(lambda x: (SIZES[x.point[0]] == max(SIZES[y] for y in x.point)) == first_is_widest)


def store_of(layout: Layout, *, ros1: bool) -> Typestore:
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    point = "\n".join(f"{kind} p{k}" for k, kind in enumerate(layout.point))
    fields = [*(f"{kind} b{k}" for k, kind in enumerate(layout.before)), "CustomPoint[] points"]
    fields += [f"{kind} a{k}" for k, kind in enumerate(layout.after)]
    store.register(get_types_from_msg(point, POINT))
    store.register(get_types_from_msg("\n".join(fields), MESSAGE))
    return store


def message_of(layout: Layout, store: Typestore) -> Any:
    rng = np.random.default_rng(layout.seed)
    header: dict[str, Any] = {
        "stamp": store.types["builtin_interfaces/msg/Time"](sec=3, nanosec=4),
        "frame_id": "odd"[: layout.seed % 4],
    }
    header |= {"seq": 7} if "seq" in store.types["std_msgs/msg/Header"].__dataclass_fields__ else {}  # type: ignore[attr-defined]
    values: dict[str, Any] = {
        "uint8": 200,
        "float64": 0.1,
        "string": "abcdefg"[: layout.seed % 7],
        "uint8[3]": np.array([1, 2, 3], np.uint8),
        "int16[]": np.arange(layout.seed % 4, dtype=np.int16),
        "geometry_msgs/Point": store.types["geometry_msgs/msg/Point"](x=1.0, y=2.0, z=3.0),
        "std_msgs/Header": store.types["std_msgs/msg/Header"](**header),
        "string[]": ["a", "bc"],
    }
    points = [
        store.types[POINT](*(bool(n & 1) if kind == "bool" else n for n, kind in zip(row, layout.point, strict=True)))
        for row in rng.integers(0, 100, (layout.records, len(layout.point))).tolist()
    ]
    return store.types[MESSAGE](*(values[x] for x in layout.before), points, *(values[x] for x in layout.after))


def type_of(store: Typestore, *, ros1: bool) -> MessageType:
    text, _ = store.generate_msgdef(MESSAGE, ros_version=1 if ros1 else 2)
    return MessageType(MESSAGE, "ros1" if ros1 else "cdr", Definition("msg", text), "humble")


def names_of(message: Any) -> list[str]:
    return [name for name in message.__dataclass_fields__ if name != "__msgtype__"]


def assert_equal(ours: Any, theirs: Any) -> None:
    for name in names_of(theirs):
        one, other = getattr(ours, name), getattr(theirs, name)
        if name == "points":
            assert [tuple(x.item() for x in record) for record in one] == [
                tuple(getattr(point, field) for field in names_of(point)) for point in other
            ]
        elif isinstance(other, np.ndarray):
            np.testing.assert_array_equal(one, other)
        elif hasattr(other, "__dataclass_fields__"):
            assert_equal(one, other)
        else:
            assert one == other


@settings(max_examples=100, deadline=None)
@given(layout=layouts(first_is_widest=True))
def test_records_among_any_fields_are_read_as_the_library_reads_them(layout: Layout) -> None:
    store = store_of(layout, ros1=False)
    message, kind = message_of(layout, store), type_of(store, ros1=False)
    for little_endian in (True, False):
        data = bytes(store.serialize_cdr(message, MESSAGE, little_endian=little_endian))
        assert_equal(kind.deserialise(data), store.deserialize_cdr(data, MESSAGE))
        assert_equal(kind.deserialise(data + bytes(3)), store.deserialize_cdr(data, MESSAGE))
        assert kind.read(data + bytes(4)).left_bytes == 4
        with pytest.raises(DatasetsError, match=r"a message of \d+ bytes, whose content takes \d+"):
            kind.deserialise(data + bytes(70))


@settings(max_examples=60, deadline=None)
@given(layout=st.one_of(layouts(first_is_widest=True), layouts(first_is_widest=False)))
def test_in_ros_1_records_of_any_numbers_lie_one_behind_the_other(layout: Layout) -> None:
    store = store_of(layout, ros1=True)
    kind = type_of(store, ros1=True)
    data = bytes(store.serialize_ros1(message_of(layout, store), MESSAGE))
    assert_equal(kind.deserialise(data), store.deserialize_ros1(data, MESSAGE))
    assert kind.read(data + bytes(1)).left_bytes == 1
    with pytest.raises(DatasetsError, match="whose content takes"):
        kind.deserialise(data + bytes(65))


@settings(max_examples=10, deadline=None)
@given(layout=layouts(first_is_widest=False))
def test_records_that_cdr_lays_out_in_several_ways_are_refused(layout: Layout) -> None:
    with pytest.raises(DatasetsError, match=f"points has records of {POINT} that do not all lie alike"):
        type_of(store_of(layout, ros1=False), ros1=False)


def test_records_of_more_than_numbers_are_refused() -> None:
    text = f"CustomPoint[] points\n{'=' * 80}\nMSG: livox_ros_driver2/CustomPoint\nstring name"
    with pytest.raises(DatasetsError, match="whose name is no plain number"):
        MessageType(MESSAGE, "ros1", Definition("msg", text), "humble")


def test_more_records_than_bytes_are_reported() -> None:
    layout = Layout(("float32",), (), (), 3, 2)
    store = store_of(layout, ros1=True)
    data = bytearray(store.serialize_ros1(message_of(layout, store), MESSAGE))
    data[:4] = (2**32 - 1).to_bytes(4, "little")
    with pytest.raises(DatasetsError, match="truncated message: 4294967295 records of points end at byte"):
        type_of(store, ros1=True).deserialise(bytes(data))
    assert len(type_of(store, ros1=True).deserialise(bytes(4)).points) == 0


@pytest.mark.parametrize("ros1", [True, False])
@pytest.mark.parametrize("frame_id", ["", "odd"])
def test_packets_with_a_stamp_and_bytes_are_read_as_the_library_reads_them(ros1: bool, frame_id: str) -> None:
    scan, packet = "velodyne_msgs/msg/VelodyneScan", "velodyne_msgs/msg/VelodynePacket"
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    store.register(get_types_from_msg("builtin_interfaces/Time stamp\nuint8[1206] data", packet))
    store.register(get_types_from_msg("std_msgs/Header header\nvelodyne_msgs/VelodynePacket[] packets", scan))
    time: Any = store.types["builtin_interfaces/msg/Time"]
    header = {"stamp": time(sec=3, nanosec=4), "frame_id": frame_id} | ({"seq": 7} if ros1 else {})
    rng = np.random.default_rng(0)
    packets = [
        store.types[packet](stamp=time(sec=5 + k, nanosec=k), data=rng.integers(0, 256, 1206, np.uint8))
        for k in range(5)
    ]
    message = store.types[scan](header=store.types["std_msgs/msg/Header"](**header), packets=packets)
    kind = MessageType(scan, "ros1" if ros1 else "cdr", None, "humble")
    order = [{}] if ros1 else [{"little_endian": True}, {"little_endian": False}]
    for options in order:
        write: Any = store.serialize_ros1 if ros1 else store.serialize_cdr
        read = kind.deserialise(bytes(write(message, scan, **options))).packets
        for one, other in zip(read, packets, strict=True):
            stamp: Any = other.stamp  # type: ignore[attr-defined]
            assert one["stamp"].tolist() == (stamp.sec, stamp.nanosec)
            np.testing.assert_array_equal(one["data"], other.data)  # type: ignore[attr-defined]
