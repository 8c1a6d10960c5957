"""A robot with a LiDAR that drives towards a wall: clouds with intensities and point times, odometry, transforms."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from recording_factory import Entry
from scipy.spatial.transform import Rotation

START_NS = 1_700_000_000_000_000_000
HEIGHT_M = 0.8
"""Height of the sensor above the ground: 0.6 above base_link, which is at 0.2."""
SWEEP_S = 0.1
_TYPES = (("x", 7), ("y", 7), ("z", 7), ("intensity", 7), ("time", 7))


def cloud_fields(xyz: NDArray[Any], intensity: NDArray[Any], time_s: NDArray[Any] | None = None) -> dict[str, Any]:
    """A PointCloud2 of float32 fields, without its header."""
    columns = [*np.asarray(xyz).T, intensity, *([] if time_s is None else [time_s])]
    table = np.stack(columns, axis=1).astype("<f4")
    fields = [
        {"name": name, "offset": 4 * place, "datatype": kind, "count": 1}
        for place, (name, kind) in enumerate(_TYPES[: len(columns)])
    ]
    step = 4 * len(columns)
    return {
        "height": 1,
        "width": len(table),
        "fields": fields,
        "point_step": step,
        "row_step": step * len(table),
        "data": np.frombuffer(table.tobytes(), np.uint8),
        "is_dense": True,
    }


def intensity_drive(
    *,
    ros1: bool = False,
    clouds: int = 8,
    rpy_rad: tuple[float, float, float] = (0.0, 0.0, 0.0),
    speed_mps: float = 0.5,
    turn_radps: float = 0.0,
    forward_m: float = 0.0,
    footprint: bool = True,
    odometry: bool = True,
    bad: Sequence[tuple[float, float, float, float]] = (),
    seen: tuple[NDArray[Any], NDArray[Any]] | None = None,
    jump_s: float | None = None,
) -> list[Entry]:
    """A wall at x = 4 m of the odometry frame, strong to the left and weak to the right, seen while driving on an arc.

    Args:
        ros1: Whether headers have a sequence.
        clouds: How many, at 10 Hz, each stamped at its end.
        rpy_rad: How the sensor is mounted.
        speed_mps: Of the robot.
        turn_radps: Of the robot.
        forward_m: Of the sensor from base_link.
        footprint: Whether tf tells how high base_link is.
        odometry: Whether there is one.
        bad: Points (x, y, z, intensity) in the sensor's frame that every cloud has besides.
        seen: Points and intensities that every cloud has in place of the wall, level around the sensor.
        jump_s: When the odometry jumps by 3 m to the left.
    """
    mount = Rotation.from_euler("xyz", rpy_rad)
    sequence = {"seq": 0} if ros1 else {}

    def header(stamp_ns: int, frame: str) -> dict[str, Any]:
        stamp = {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}
        return {"header": {**sequence, "stamp": stamp, "frame_id": frame}}

    def transform(child: str, xyz: Sequence[float], turn: Rotation) -> dict[str, Any]:
        rotation = dict(zip("xyzw", map(float, np.ravel(turn.as_quat())), strict=True))
        pose = {"translation": dict(zip("xyz", map(float, xyz), strict=True)), "rotation": rotation}
        return {**header(START_NS, "base_link"), "child_frame_id": child, "transform": pose}

    transforms = [transform("lidar", (forward_m, 0.0, 0.6), mount)]
    if footprint:
        transforms.append(transform("base_footprint", (0.0, 0.0, -0.2), Rotation.identity()))
    entries: list[Entry] = [("/tf_static", "tf2_msgs/msg/TFMessage", START_NS, {"transforms": transforms})]
    end_s = (clouds + 1.5) * SWEEP_S
    for time_s in np.arange(0.0, end_s + 0.1, 0.02) if odometry else ():
        stamp_ns = START_NS + round(time_s * 1e9)
        place, yaw = _on_arc(np.array([time_s]), speed_mps, turn_radps)
        turned = {"x": 0.0, "y": 0.0, "z": float(np.sin(yaw[0] / 2)), "w": float(np.cos(yaw[0] / 2))}
        aside_m = 3.0 if jump_s is not None and time_s >= jump_s else 0.0
        position = {"x": float(place[0, 0]), "y": float(place[0, 1]) + aside_m, "z": 0.0}
        fields = {
            **header(stamp_ns, "odom"),
            "child_frame_id": "base_link",
            "pose": {"pose": {"position": position, "orientation": turned}},
            "twist": {"twist": {"linear": {"x": speed_mps, "y": 0.0, "z": 0.0}}},
        }
        entries.append(("/odom", "nav_msgs/msg/Odometry", stamp_ns, fields))
    for number in range(clouds):
        stamp_ns = START_NS + round((number + 1.5) * SWEEP_S * 1e9)
        xyz, intensity, times = _wall((stamp_ns - START_NS) * 1e-9, speed_mps, turn_radps, forward_m)
        if seen is not None:
            xyz, intensity, times = seen[0], seen[1], np.zeros(len(seen[0]))
        in_sensor = mount.inv().apply(xyz)
        if bad:
            in_sensor = np.concatenate([in_sensor, np.array(bad)[:, :3]])
            intensity = np.concatenate([intensity, np.array(bad)[:, 3]])
            times = np.concatenate([times, np.full(len(bad), -0.01)])
        fields = {**header(stamp_ns, "lidar"), **cloud_fields(in_sensor, intensity, times)}
        entries.append(("/points", "sensor_msgs/msg/PointCloud2", stamp_ns + 2_000_000, fields))
    return sorted(entries, key=lambda entry: entry[2])


def _on_arc(time_s: NDArray[Any], speed_mps: float, turn_radps: float) -> tuple[NDArray[Any], NDArray[Any]]:
    yaw = turn_radps * time_s
    if turn_radps == 0:
        return np.stack([speed_mps * time_s, 0 * time_s], axis=1), yaw
    return speed_mps / turn_radps * np.stack([np.sin(yaw), 1 - np.cos(yaw)], axis=1), yaw


def _wall(
    stamp_s: float, speed_mps: float, turn_radps: float, forward_m: float
) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Points of the wall as the sensor, level, sees each at its own time; intensities; times from the stamp."""
    y, z = (part.ravel() for part in np.meshgrid(np.arange(-3.0, 3.0, 0.02), np.arange(-0.5, 1.0, 0.1)))
    times = -SWEEP_S * (np.arange(y.size) % 300) / 300
    place, yaw = _on_arc(stamp_s + times, speed_mps, turn_radps)
    dx, dy = 4.0 - place[:, 0], y - place[:, 1]
    x, left = np.cos(yaw) * dx + np.sin(yaw) * dy, np.cos(yaw) * dy - np.sin(yaw) * dx
    return np.stack([x - forward_m, left, z], axis=1), np.where(y > 0, 240.0, 60.0), times
