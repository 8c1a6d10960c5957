"""Recordings in which several sources publish on one topic, beside a camera and an odometry that stand still."""

from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore
from turning_drive import START_NS, Entry, TurningDrive, cloud

FRONT, REAR = "lidar_front", "lidar_rear"
ARM = ("shoulder", "elbow", "wrist")
WHEELS = ("left_wheel", "right_wheel")
_LEVEL, _BACK, _ON_ITS_HEAD = ({"w": 1.0}, {"z": 1.0}, {"x": 1.0})


def header(time_s: float, frame: str) -> dict[str, Any]:
    stamp_ns = START_NS + round(time_s * 1e9)
    return {"header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": frame}}


def base(seconds: float = 3.0) -> list[Entry]:
    return TurningDrive(seconds=seconds, turns=False, streams=("camera", "odometry")).entries()


def mounts(poses: dict[str, tuple[float, dict[str, float]]]) -> Entry:
    """tf_static with each frame so far ahead of the base, turned so."""
    transforms = [
        {
            **header(0.0, "base_link"),
            "child_frame_id": frame,
            "transform": {"translation": {"x": ahead_m}, "rotation": rotation},
        }
        for frame, (ahead_m, rotation) in poses.items()
    ]
    return "/tf_static", "tf2_msgs/msg/TFMessage", START_NS, {"transforms": transforms}


def at(time_s: float, topic: str, kind: str, fields: dict[str, Any]) -> Entry:
    return topic, kind, START_NS + round(time_s * 1e9) + 5_000_000, fields


def pole(ahead_m: float = 1.5) -> np.ndarray[Any, np.dtype[np.float32]]:
    """A pole ahead of the sensor itself."""
    height = np.linspace(-0.5, 0.5, 60)
    return np.column_stack([np.full(60, ahead_m), 0.01 * np.arange(60), height]).astype(np.float32)


def two_lidars(seconds: float = 3.0, one_after_the_other: bool = False) -> list[Entry]:
    """One looks ahead, one back, on /points; by turns, or the second once the first is done."""
    entries = [*base(seconds), mounts({FRONT: (0.4, _LEVEL), REAR: (-0.4, _BACK)})]
    count = round(seconds * 10)
    for number in range(2 * count):
        rear = number >= count if one_after_the_other else number % 2 == 1
        time_s = number / 20
        fields = {**header(time_s, REAR if rear else FRONT), **cloud(pole(), number)}
        entries.append(at(time_s, "/points", "sensor_msgs/msg/PointCloud2", fields))
    return sorted(entries, key=lambda entry: entry[2])


def two_imus(seconds: float = 3.0) -> list[Entry]:
    """One level and one on its head, on /imu/data, by turns; the one on its head twice as often."""
    entries = [*base(seconds), mounts({"imu_a": (0.0, _LEVEL), "imu_b": (0.0, _ON_ITS_HEAD)})]
    for number in range(round(seconds * 90)):
        up = -1.0 if number % 3 else 1.0
        fields = {
            **header(number / 90, "imu_b" if number % 3 else "imu_a"),
            "angular_velocity": {"z": 0.4 * up},
            "linear_acceleration": {"z": 9.81 * up},
        }
        entries.append(at(number / 90, "/imu/data", "sensor_msgs/msg/Imu", fields))
    return sorted(entries, key=lambda entry: entry[2])


def angle(joint: str, time_s: float) -> float:
    """Where a joint is; each has its own pace."""
    return (1 + (*ARM, *WHEELS).index(joint)) * 0.1 * time_s


def joints(time_s: float, names: tuple[str, ...], still: tuple[str, ...] = ()) -> dict[str, Any]:
    values = np.array([0.0 if name in still else angle(name, time_s) for name in names])
    return {
        **header(time_s, ""),
        "name": list(names),
        "position": values,
        "velocity": 0 * values + 0.1,
        "effort": values,
    }


def two_joint_publishers(
    seconds: float = 3.0, later_s: float = 0.007, second: tuple[str, ...] = WHEELS, still: tuple[str, ...] = ()
) -> list[Entry]:
    """The arm's driver and another one on /joint_states, each at 50 Hz.

    Args:
        later_s: By how much the second's stamps are later than the first's.
        second: Joints that the second names.
        still: Those of them that it does not measure: 0 and never another value.
    """
    entries = base(seconds)
    for number in range(round(seconds * 50)):
        for begins_s, names in ((0.0, ARM), (later_s, second)):
            time_s = number / 50 + begins_s
            fields = joints(time_s, names, still if names is second else ())
            if names is second and still:
                fields["velocity"] = np.where([name in still for name in names], 0.0, 0.1)
            entries.append(at(time_s, "/joint_states", "sensor_msgs/msg/JointState", fields))
    return sorted(entries, key=lambda entry: entry[2])


def two_nodes(path: Path) -> Path:
    """A ROS 1 bag in which two nodes publish the same odometry's frames on /odom: the wheels' stands still."""
    store = get_typestore(Stores.ROS1_NOETIC)
    types, zeros = store.types, np.zeros(36)
    with Writer(path) as writer:
        kind = "nav_msgs/msg/Odometry"
        connections = {
            node: writer.add_connection("/odom", kind, typestore=store, callerid=node) for node in ("/wheels", "/ekf")
        }
        for number in range(120):
            node = "/ekf" if number % 3 == 0 else "/wheels"
            stamp_ns = START_NS + number * 25_000_000
            time = types["builtin_interfaces/msg/Time"](stamp_ns // 10**9, stamp_ns % 10**9)
            point = types["geometry_msgs/msg/Point"](10.0 if node == "/ekf" else 0.0, 0.0, 0.0)
            pose = types["geometry_msgs/msg/Pose"](point, types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0))
            still = types["geometry_msgs/msg/Vector3"](0.0, 0.0, 0.0)
            message = types[kind](
                types["std_msgs/msg/Header"](number, time, "odom"),
                "base_link",
                types["geometry_msgs/msg/PoseWithCovariance"](pose, zeros),
                types["geometry_msgs/msg/TwistWithCovariance"](types["geometry_msgs/msg/Twist"](still, still), zeros),
            )
            writer.write(connections[node], stamp_ns, store.serialize_ros1(message, kind))
    return path
