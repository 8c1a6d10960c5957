"""A robot that turns this way and that between walls, as its sensors see it, each with a clock of its own."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from navtool.pipeline.arrays import Array

Entry = tuple[str, str, int, dict[str, Any]]
START_NS = 1_750_000_000_000_000_000
SPEED_MPS = 0.5
TOPICS = {
    "camera": "/camera/image_raw",
    "lidar": "/points",
    "odometry": "/odom",
    "imu": "/imu/data",
    "command": "/cmd_vel",
}
RATES_HZ = {"camera": 10, "lidar": 10, "odometry": 20, "imu": 50, "command": 10}
_OPTICAL = {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}
_LEVEL = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}


@dataclass(frozen=True, kw_only=True)
class TurningDrive:
    """What the sensors recorded.

    Attributes:
        seconds: How long.
        turns: Whether the robot turns this way and that; else it turns steadily, which tells no clock from another.
        header_s: What is added to the header stamps of a stream.
        late_s: How long after the measurement a stream is recorded; 5 ms where it is not said.
        jitter_s: By how much more, now and then.
        rates_hz: Of streams that come at another rate than the usual one.
        drift: How much faster than the recorder's a stream's header clock runs.
    """

    seconds: float = 12.0
    turns: bool = True
    streams: tuple[str, ...] = ("camera", "lidar", "odometry", "imu", "command")
    header_s: Mapping[str, float] = field(default_factory=dict)
    late_s: Mapping[str, float] = field(default_factory=dict)
    jitter_s: Mapping[str, float] = field(default_factory=dict)
    drift: Mapping[str, float] = field(default_factory=dict)
    rates_hz: Mapping[str, float] = field(default_factory=dict)

    def rate_radps(self, time_s: float) -> float:
        """The turning rate, to the left."""
        if not self.turns:
            return 0.4
        return float(0.5 * np.sin(1.3 * time_s) + 0.4 * np.sin(2.9 * time_s + 1) + 0.3 * np.sin(0.37 * time_s**1.5))

    def entries(self) -> list[Entry]:
        """The messages in the order of record."""
        fine = np.arange(0.0, self.seconds + 0.02, 0.002)
        rates = np.array([self.rate_radps(time_s) for time_s in fine.tolist()])
        yaws = np.concatenate([[0.0], np.cumsum((rates[1:] + rates[:-1]) / 2 * 0.002)])
        forward = np.cumsum(np.column_stack([np.cos(yaws), np.sin(yaws)]) * SPEED_MPS * 0.002, axis=0)
        entries: list[Entry] = [("/tf_static", "tf2_msgs/msg/TFMessage", START_NS, {"transforms": _mounts()})]
        for stream in self.streams:
            rate_hz = self.rates_hz.get(stream, RATES_HZ[stream])
            for number in range(int(self.seconds * rate_hz) + 1):
                time_s = number / rate_hz
                at = round(time_s / 0.002)
                pose = float(yaws[at]), float(forward[at, 0]), float(forward[at, 1])
                header_s = self.header_s.get(stream, 0.0) + self.drift.get(stream, 0.0) * time_s
                header = _header(START_NS + round((time_s + header_s) * 1e9), FRAMES[stream])
                kind, fields = _message(stream, header, pose, self.rate_radps(time_s), number)
                late_s = (
                    self.late_s.get(stream, 0.005) + self.jitter_s.get(stream, 0.0) * (1 + np.sin(0.9 * time_s)) / 2
                )
                entries.append((TOPICS[stream], kind, START_NS + round((time_s + late_s) * 1e9), fields))
        return sorted(entries, key=lambda entry: entry[2])


FRAMES = {"camera": "camera_optical", "lidar": "lidar", "odometry": "odom", "imu": "imu_link", "command": ""}


def _header(stamp_ns: int, frame: str) -> dict[str, Any]:
    return {"header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": frame}}


def _mounts() -> list[dict[str, Any]]:
    return [
        {
            **_header(START_NS, "base_link"),
            "child_frame_id": child,
            "transform": {"translation": {"x": 0.0, "y": 0.0, "z": 0.5}, "rotation": rotation},
        }
        for child, rotation in (("camera_optical", _OPTICAL), ("lidar", _LEVEL), ("imu_link", _LEVEL))
    ]


def _message(
    stream: str, header: dict[str, Any], pose: tuple[float, float, float], rate_radps: float, number: int
) -> tuple[str, dict[str, Any]]:
    yaw, x, y = pose
    match stream:
        case "camera":
            return "sensor_msgs/msg/Image", {**header, **_picture(yaw)}
        case "lidar":
            return "sensor_msgs/msg/PointCloud2", {**header, **cloud(walls(yaw, x, y), number)}
        case "odometry":
            attitude = {"z": float(np.sin(yaw / 2)), "w": float(np.cos(yaw / 2))}
            return "nav_msgs/msg/Odometry", {
                **header,
                "child_frame_id": "base_link",
                "pose": {"pose": {"position": {"x": x, "y": y}, "orientation": attitude}},
                "twist": {"twist": {"linear": {"x": SPEED_MPS}, "angular": {"z": rate_radps}}},
            }
        case "imu":
            return "sensor_msgs/msg/Imu", {
                **header,
                "angular_velocity": {"z": rate_radps},
                "linear_acceleration": {"z": 9.81},
            }
        case _:
            return "geometry_msgs/msg/Twist", {"linear": {"x": SPEED_MPS}, "angular": {"z": rate_radps}}


_ROUND = np.random.default_rng(5).integers(0, 255, (48, 720), dtype=np.uint8)
"""What stands around, by height and half degree of azimuth."""


def _picture(yaw_rad: float) -> dict[str, Any]:
    """A camera that sees 80 degrees, whose left is more to the left in the world."""
    columns = np.round((np.degrees(yaw_rad) + 40 - np.arange(96) * 80 / 96) * 2).astype(np.int64) % 720
    grey = _ROUND[:, columns]
    rgb = np.repeat(grey[:, :, None], 3, axis=2)
    return {"height": 48, "width": 96, "encoding": "rgb8", "step": 288, "data": rgb.ravel()}


def walls(yaw_rad: float, x_m: float, y_m: float) -> Array:
    """Four walls of 18 m, and a pillar, as points around a robot within them."""
    azimuth = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    direction = azimuth + yaw_rad
    cosine, sine = np.cos(direction), np.sin(direction)
    along = np.where(cosine > 0, 12.0 - x_m, 6.0 + x_m) / np.maximum(np.abs(cosine), 1e-6)
    across = np.where(sine > 0, 11.0 - y_m, 7.0 + y_m) / np.maximum(np.abs(sine), 1e-6)
    reach = np.minimum(along, across)
    to_pillar = np.arctan2(-3.0 - y_m, 1.0 - x_m)
    pillar = np.abs((direction - to_pillar + np.pi) % (2 * np.pi) - np.pi) < 0.1
    reach = np.where(pillar, np.minimum(reach, np.hypot(-3.0 - y_m, 1.0 - x_m)), reach)
    return np.column_stack([reach * np.cos(azimuth), reach * np.sin(azimuth), np.zeros(720)]).astype(np.float32)


def cloud(xyz: Array, number: int) -> dict[str, Any]:
    """A PointCloud2 whose intensity is its number."""
    table = np.zeros(len(xyz), dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4")])
    table["x"], table["y"], table["z"] = xyz.T
    table["intensity"] = number
    names = ("x", "y", "z", "intensity")
    return {
        "height": 1,
        "width": len(xyz),
        "fields": [{"name": name, "offset": 4 * k, "datatype": 7, "count": 1} for k, name in enumerate(names)],
        "point_step": 16,
        "row_step": 16 * len(xyz),
        "data": np.frombuffer(table.tobytes(), np.uint8),
        "is_dense": True,
    }
