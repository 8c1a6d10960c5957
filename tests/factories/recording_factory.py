"""A factory of tiny recordings in every container, written by the formats' own writers."""

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import mcap.writer
import numpy as np
import pytest
from rosbags import rosbag1, rosbag2
from rosbags.interfaces import Nodetype
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from navtool.datasets.recording.message_type import MessageType, message_type
from navtool.datasets.recording.source import Definition

type Fields = Mapping[str, Any]
type Types = tuple[tuple[str, str], ...]
"""Message types and their definitions, in place of those that the factory knows."""
type Entry = tuple[str, str, int, Fields]
"""Topic, type, record time in nanoseconds, fields; what the fields leave out is zero, empty or false."""

_ROS1 = {
    "ros1": None,
    "ros1_bz2": rosbag1.Writer.CompressionFormat.BZ2,
    "ros1_lz4": rosbag1.Writer.CompressionFormat.LZ4,
}
_ROS2 = {
    "db3": (StoragePlugin.SQLITE3, CompressionMode.NONE),
    "db3_message": (StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
    "db3_file": (StoragePlugin.SQLITE3, CompressionMode.FILE),
    "mcap": (StoragePlugin.MCAP, CompressionMode.NONE),
    "mcap_zstd": (StoragePlugin.MCAP, CompressionMode.STORAGE),
    "mcap_message": (StoragePlugin.MCAP, CompressionMode.MESSAGE),
    "mcap_file": (StoragePlugin.MCAP, CompressionMode.FILE),
}
_MCAP: dict[str, dict[str, Any]] = {
    "mcap_lz4": {"compression": mcap.writer.CompressionType.LZ4, "chunk_size": 200},
    "mcap_small_chunks": {"compression": mcap.writer.CompressionType.ZSTD, "chunk_size": 200},
    "mcap_unchunked": {"use_chunking": False},
    "mcap_no_summary": {
        "index_types": mcap.writer.IndexType.NONE,
        "repeat_channels": False,
        "repeat_schemas": False,
        "use_statistics": False,
        "use_summary_offsets": False,
    },
    "mcap_ros1": {"compression": mcap.writer.CompressionType.NONE},
}
CONTAINERS = (*_ROS1, *_ROS2, *_MCAP)


@pytest.fixture(params=CONTAINERS)
def container(request: pytest.FixtureRequest) -> str:
    """Each storage format with each of its compressions and layouts in turn."""
    return str(request.param)


@pytest.fixture
def containers() -> tuple[str, ...]:
    return CONTAINERS


@pytest.fixture(scope="session")
def recording_writer() -> Callable[..., Path]:
    """``recording_writer(folder, container, entries, name="bag", types=(), chunk_bytes=None) -> Path`` of what to open.

    ``chunk_bytes`` is the size of chunks where the writer lets it be chosen; None leaves the container's usual one.
    """

    def write(
        folder: Path,
        container: str,
        entries: Iterable[Entry],
        name: str = "bag",
        types: Types = (),
        chunk_bytes: int | None = None,
    ) -> Path:
        path = folder / name
        if container in _ROS1:
            return _write_ros1(path.with_name(f"{name}.bag"), container, entries, types, chunk_bytes)
        if container in _ROS2:
            return _write_ros2(path, container, entries, types)
        return _write_mcap(path.with_name(f"{name}.mcap"), container, entries, types, chunk_bytes)

    return write


@pytest.fixture
def write_recording(tmp_path: Path, recording_writer: Callable[..., Path]) -> Callable[..., Path]:
    """``write_recording(container, entries, name="bag", types=()) -> Path`` of what to open; in the order given."""

    def write(container: str, entries: Iterable[Entry], name: str = "bag", types: Types = ()) -> Path:
        return recording_writer(tmp_path, container, entries, name, types)

    return write


@pytest.fixture
def ros_message() -> Callable[..., Any]:
    """``ros_message(type, fields, ros1=False, types=())``: the message as an object, as a reader would hand it out."""

    def message(kind: str, fields: Fields, *, ros1: bool = False, types: Types = ()) -> Any:
        store = _store(ros1=ros1, types=types)
        serialise = store.serialize_ros1 if ros1 else store.serialize_cdr
        return _reader(kind, ros1=ros1, types=types).deserialise(bytes(serialise(_build(store, kind, fields), kind)))

    return message


@pytest.fixture
def cdr() -> Callable[..., bytes]:
    """``cdr(type, fields, little_endian=True)``: the message serialised for ROS 2."""

    def serialise(kind: str, fields: Fields, *, little_endian: bool = True) -> bytes:
        store = _store(ros1=False)
        return bytes(store.serialize_cdr(_build(store, kind, fields), kind, little_endian=little_endian))

    return serialise


_MORE_TYPES = {
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "tf/msg/tfMessage": "geometry_msgs/TransformStamped[] transforms",
    "anymal_msgs/msg/ExtendedJointState": "std_msgs/Header header\nstring[] name\nfloat64[] position\n"
    "float64[] velocity\nfloat64[] acceleration\nfloat64[] effort",
    "anymal_msgs/msg/AnymalState": "std_msgs/Header header\nint8 state\nanymal_msgs/ExtendedJointState joints",
    "anymal_msgs/msg/BatteryState": "uint8 STATUS_DISCHARGING=2\nstd_msgs/Header header\nbool is_connected\n"
    "float32 voltage\nfloat32 current\nfloat32 state_of_charge\nuint8 status",
    "clearpath_platform_msgs/msg/Power": "std_msgs/Header header\nint8 battery_connected\n"
    "uint8 A200_CURRENTS_SIZE=3\nfloat32[] measured_voltages\nfloat32[] measured_currents",
    **{
        f"{package}/msg/CompressedPointCloud2": "std_msgs/Header header\nuint32 height\nuint32 width\n"
        "sensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\nuint32 row_step\n"
        f"uint8[] compressed_data\nbool is_dense{more}"
        for package, more in (("point_cloud_interfaces", "\nstring format"), ("draco_point_cloud_transport", ""))
    },
    "ffmpeg_image_transport_msgs/msg/FFMPEGPacket": "std_msgs/Header header\nint32 width\nint32 height\n"
    "string encoding\nuint64 pts\nuint8 flags\nbool is_bigendian\nuint8[] data",
    "husky_msgs/msg/HuskyStatus": "std_msgs/Header header\nfloat64 mcu_and_user_port_current\n"
    "float64 left_driver_current\nfloat64 right_driver_current\nfloat64 battery_voltage\nbool lockout\nbool e_stop",
    "jackal_msgs/msg/Status": "std_msgs/Header header\nfloat32 measured_battery\nfloat32 drive_current\n"
    "float32 total_current",
    "racepak/msg/rp_controls": "float32 throttle\nfloat32 brake",
    "spot_msgs/msg/BatteryState": "std_msgs/Header header\nstring identifier\nfloat64 charge_percentage\n"
    "float64 current\nfloat64 voltage",
    "spot_msgs/msg/BatteryStateArray": "spot_msgs/BatteryState[] battery_states",
    "unitree_go/msg/IMUState": "float32[4] quaternion\nfloat32[3] gyroscope\nfloat32[3] accelerometer",
    "unitree_go/msg/MotorState": "uint8 mode\nfloat32 q\nfloat32 dq\nfloat32 ddq\nfloat32 tau_est",
    "unitree_go/msg/BmsState": "uint8 status\nuint8 soc\nint32 current",
    "unitree_go/msg/LowState": "uint8[2] head\nunitree_go/IMUState imu_state\nunitree_go/MotorState[20] motor_state\n"
    "unitree_go/BmsState bms_state\nint16[4] foot_force\nuint32 tick\nfloat32 power_v",
    "unitree_go/msg/SportModeState": "builtin_interfaces/Time stamp\nunitree_go/IMUState imu_state\nuint8 mode\n"
    "float32[3] position\nfloat32[3] velocity\nfloat32 yaw_speed",
    **{
        f"{package}/msg/CustomPoint": "uint32 offset_time\nfloat32 x\nfloat32 y\nfloat32 z\n"
        "uint8 reflectivity\nuint8 tag\nuint8 line"
        for package in ("livox_ros_driver", "livox_ros_driver2", "livox_interfaces")
    },
    **{
        f"{package}/msg/CustomMsg": "std_msgs/Header header\nuint64 timebase\nuint32 point_num\nuint8 lidar_id\n"
        f"uint8[3] rsvd\n{package}/CustomPoint[] points"
        for package in ("livox_ros_driver", "livox_ros_driver2", "livox_interfaces")
    },
    "unitree_legged_msgs/msg/BmsState": "uint8 bms_status\nuint8 SOC\nint32 current\nuint16[10] cell_vol",
    "unitree_legged_msgs/msg/IMU": "float32[4] quaternion\nfloat32[3] gyroscope\nfloat32[3] accelerometer\n"
    "float32[3] rpy\nint8 temperature",
    "unitree_legged_msgs/msg/MotorState": "uint8 mode\nfloat32 q\nfloat32 dq\nfloat32 ddq\nfloat32 tauEst",
    "unitree_legged_msgs/msg/HighState": "uint8[2] head\nuint8 levelFlag\nunitree_legged_msgs/IMU imu\n"
    "unitree_legged_msgs/MotorState[20] motorState\nunitree_legged_msgs/BmsState bms\nint16[4] footForce\nuint8 mode",
    "velodyne_msgs/msg/VelodynePacket": "builtin_interfaces/Time stamp\nuint8[1206] data",
    "velodyne_msgs/msg/VelodyneScan": "std_msgs/Header header\nvelodyne_msgs/VelodynePacket[] packets",
    "warthog_msgs/msg/Status": "std_msgs/Header header\nstring hardware_id\nduration mcu_uptime\nbool stop_engaged\n"
    "float32 measured_battery\nfloat32 measured_48v\nfloat32 current_battery\nfloat32 current_48v",
}


@cache
def _reader(kind: str, *, ros1: bool, types: Types = ()) -> MessageType:
    text, _ = _store(ros1=ros1, types=types).generate_msgdef(kind, ros_version=1 if ros1 else 2)
    return message_type(kind, "ros1" if ros1 else "cdr", Definition("msg", text), "humble")


@cache
def _store(*, ros1: bool, types: Types = ()) -> Typestore:
    store = get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_HUMBLE)
    for kind, text in (_MORE_TYPES | dict(types)).items():
        if kind not in store.fielddefs:
            store.register(get_types_from_msg(text, kind))
    return store


def _write_ros1(path: Path, container: str, entries: Iterable[Entry], types: Types, chunk_bytes: int | None) -> Path:
    store = _store(ros1=True, types=types)
    writer = rosbag1.Writer(path)
    if chunk_bytes is not None:
        writer.chunk_threshold = chunk_bytes
    compression = _ROS1[container]
    if compression is not None:
        writer.set_compression(compression)
    with writer:
        connections: dict[tuple[str, str], Any] = {}
        for topic, kind, record_ns, fields in entries:
            if (topic, kind) not in connections:
                connections[topic, kind] = writer.add_connection(topic, kind, typestore=store)
            data = store.serialize_ros1(_build(store, kind, fields), kind)
            writer.write(connections[topic, kind], record_ns, bytes(data))
    return path


def _write_ros2(path: Path, container: str, entries: Iterable[Entry], types: Types) -> Path:
    store = _store(ros1=False, types=types)
    plugin, mode = _ROS2[container]
    writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    writer.set_compression(mode, CompressionFormat.ZSTD)
    with writer:
        connections: dict[tuple[str, str], Any] = {}
        for topic, kind, record_ns, fields in entries:
            if (topic, kind) not in connections:
                connections[topic, kind] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic, kind], record_ns, store.serialize_cdr(_build(store, kind, fields), kind))
    return path


def _write_mcap(path: Path, container: str, entries: Iterable[Entry], types: Types, chunk_bytes: int | None) -> Path:
    ros1 = container == "mcap_ros1"
    store = _store(ros1=ros1, types=types)
    options = _MCAP[container] | ({} if chunk_bytes is None else {"chunk_size": chunk_bytes})
    with path.open("wb") as stream:
        writer: Any = mcap.writer.Writer(stream, **options)
        writer.start(profile="ros1" if ros1 else "ros2")
        channels: dict[tuple[str, str], int] = {}
        for topic, kind, record_ns, fields in entries:
            if (topic, kind) not in channels:
                text, _ = store.generate_msgdef(kind, ros_version=1 if ros1 else 2)
                name = kind.replace("/msg/", "/") if ros1 else kind
                schema = writer.register_schema(name, "ros1msg" if ros1 else "ros2msg", text.encode())
                channels[topic, kind] = writer.register_channel(topic, "ros1" if ros1 else "cdr", schema)
            serialise = store.serialize_ros1 if ros1 else store.serialize_cdr
            data = bytes(serialise(_build(store, kind, fields), kind))
            writer.add_message(channels[topic, kind], record_ns, data, record_ns)
        writer.finish()
    return path


def _build(store: Typestore, kind: str, fields: Fields) -> Any:
    """The message of a type; its parts are given as mappings, and what is not given is zero, empty or false."""
    values = {}
    for name, (node, description) in store.fielddefs[kind][1]:
        # ROS 1 writes the matrices of CameraInfo in upper case.
        given = fields.get(name, fields.get(name.lower()))
        values[name] = _value(store, node, description, given)
    return store.types[kind](**values)


def _value(store: Typestore, node: int, description: Any, given: Any) -> Any:
    if node == Nodetype.NAME:
        return _build(store, description, given or {})
    if node == Nodetype.BASE:
        zero: Any = {"string": "", "bool": False}.get(description[0], 0)
        return zero if given is None else given
    (inner, inner_description), length = description
    if inner == Nodetype.NAME:
        parts = [_build(store, inner_description, x) for x in given or []]
        return parts + [_build(store, inner_description, {}) for _ in range(max(length - len(parts), 0))]
    if inner_description[0] == "string":
        return list(given or [])
    size = length if node == Nodetype.ARRAY else 0
    return np.zeros(size, inner_description[0]) if given is None else np.asarray(given, inner_description[0])
