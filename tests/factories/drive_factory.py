"""A factory of short drives with every stream, and of data sets made from them, by the real writers and by ingest."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import RobotConfig

Entry = tuple[str, str, int, dict[str, Any]]
START_NS = 1_700_000_000_000_000_000
RECORD_DELAY_NS = 3_000_000
JOINTS = ("front_left", "front_right")
STREAMS = ("camera", "lidar", "odometry", "imu", "joints", "battery", "command", "intervention", "tf")
REAR = ("camera.rear", "lidar.rear")
"""A second camera at 10 Hz, on /rear_camera, and a second LiDAR at 5 Hz, on /rear_points; only where they are asked."""
NATIVE = (128, 96)


def _header(time_ns: int, frame: str, *, ros1: bool) -> dict[str, Any]:
    stamp = {"sec": time_ns // 10**9, "nanosec": time_ns % 10**9}
    return {"header": {"stamp": stamp, "frame_id": frame, **({"seq": 0} if ros1 else {})}}


def _vector(x: float, y: float = 0.0, z: float = 0.0) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


def _jpeg(number: int, seed: int) -> np.ndarray[tuple[int], np.dtype[np.uint8]]:
    rng = np.random.default_rng(seed)
    scene = cv2.resize(rng.integers(0, 255, (24, 64, 3), dtype=np.uint8), (512, NATIVE[1]))
    shift = (number * 6) % (512 - NATIVE[0])
    return cv2.imencode(".jpg", np.ascontiguousarray(scene[:, shift : shift + NATIVE[0]]))[1].ravel()


def _cloud(number: int, seed: int) -> dict[str, Any]:
    rng = np.random.default_rng(seed * 1000 + number)
    points = 600
    table = np.zeros(points, dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2")])
    for axis in "xy":
        table[axis] = rng.uniform(-15, 15, points)
    table["z"] = rng.uniform(-0.5, 2, points)
    table["intensity"] = rng.uniform(0, 100, points)
    table["ring"] = np.repeat(np.arange(16), points // 16 + 1)[:points]
    kinds = {"<f4": 7, "<u2": 4}
    described: Any = table.dtype.fields
    fields = [
        {"name": name, "offset": offset, "datatype": kinds[kind.str], "count": 1}
        for name, (kind, offset, *_) in described.items()
    ]
    step = table.dtype.itemsize
    return {
        "height": 1,
        "width": points,
        "fields": fields,
        "point_step": step,
        "row_step": step * points,
        "data": np.frombuffer(table.tobytes(), np.uint8),
        "is_dense": True,
    }


def drive(
    seconds: float = 3.0, *, seed: int = 0, streams: tuple[str, ...] = STREAMS, ros1: bool = False, crash: bool = True
) -> list[Entry]:
    """A robot that drives 1 m/s straight on, and stops hard at two thirds of the time while still commanded to go."""
    entries: list[Entry] = []
    stop_s = seconds * 2 / 3 if crash else np.inf

    def every(rate_hz: float, phase_s: float = 0.0) -> Iterator[tuple[int, float, int]]:
        for number in range(int(seconds * rate_hz)):
            time_s = phase_s + number / rate_hz
            yield number, time_s, START_NS + round(time_s * 1e9)

    def add(stream: str, topic: str, kind: str, time_ns: int, fields: dict[str, Any]) -> None:
        if stream in streams:
            entries.append((topic, kind, time_ns + RECORD_DELAY_NS, fields))

    quaternion = {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}
    optical = {"x": -0.5, "y": 0.5, "z": -0.5, "w": 0.5}
    mounts = [("base_link", "camera_optical", 0.2, 0.4, optical), ("base_link", "lidar", 0.0, 0.6, quaternion)]
    if "camera.rear" in streams:
        mounts.append(("base_link", "rear_optical", -0.3, 0.4, {"x": 0.5, "y": 0.5, "z": -0.5, "w": -0.5}))
    transforms = [
        {
            **_header(START_NS, parent, ros1=ros1),
            "child_frame_id": child,
            "transform": {"translation": _vector(x, 0.0, z), "rotation": rotation},
        }
        for parent, child, x, z, rotation in (*mounts, ("base_link", "imu_link", 0.0, 0.1, quaternion))
    ]
    add("tf", "/tf_static", "tf2_msgs/msg/TFMessage", START_NS, {"transforms": transforms})
    focal = 0.8 * NATIVE[0]
    camera = {
        "width": NATIVE[0],
        "height": NATIVE[1],
        "distortion_model": "plumb_bob",
        "d": np.zeros(5),
        "k": np.array([focal, 0, NATIVE[0] / 2 - 0.5, 0, focal, NATIVE[1] / 2 - 0.5, 0, 0, 1]),
        "r": np.eye(3).ravel(),
        "p": np.array([focal, 0, NATIVE[0] / 2 - 0.5, 0, 0, focal, NATIVE[1] / 2 - 0.5, 0, 0, 0, 1, 0]),
    }
    add(
        "camera",
        "/camera/camera_info",
        "sensor_msgs/msg/CameraInfo",
        START_NS,
        {**_header(START_NS, "camera_optical", ros1=ros1), **camera},
    )
    for number, _, stamp in every(15):
        fields = {**_header(stamp, "camera_optical", ros1=ros1), "format": "jpeg", "data": _jpeg(number, seed)}
        add("camera", "/camera/image_raw/compressed", "sensor_msgs/msg/CompressedImage", stamp, fields)
    for number, _, stamp in every(10, 0.02):
        fields = {**_header(stamp, "lidar", ros1=ros1), **_cloud(number, seed)}
        add("lidar", "/points", "sensor_msgs/msg/PointCloud2", stamp, fields)
    info = {**_header(START_NS, "rear_optical", ros1=ros1), **camera}
    add("camera.rear", "/rear_camera/camera_info", "sensor_msgs/msg/CameraInfo", START_NS, info)
    for number, _, stamp in every(10, 0.01):
        fields = {**_header(stamp, "rear_optical", ros1=ros1), "format": "jpeg", "data": _jpeg(number, seed + 100)}
        add("camera.rear", "/rear_camera/image_raw/compressed", "sensor_msgs/msg/CompressedImage", stamp, fields)
    for number, _, stamp in every(5, 0.03):
        fields = {**_header(stamp, "rear_lidar", ros1=ros1), **_cloud(number, seed + 100)}
        add("lidar.rear", "/rear_points", "sensor_msgs/msg/PointCloud2", stamp, fields)
    for _, time_s, stamp in every(50):
        moving = time_s < stop_s
        pose = {"position": _vector(min(time_s, stop_s)), "orientation": quaternion}
        twist = {"linear": _vector(1.0 if moving else 0.0), "angular": _vector(0.0)}
        fields = {
            **_header(stamp, "odom", ros1=ros1),
            "child_frame_id": "base_link",
            "pose": {"pose": pose},
            "twist": {"twist": twist},
        }
        add("odometry", "/odom", "nav_msgs/msg/Odometry", stamp, fields)
    for _, time_s, stamp in every(100):
        spike = -40.0 if 0 <= time_s - stop_s < 0.03 else 0.0
        fields = {
            **_header(stamp, "imu_link", ros1=ros1),
            "linear_acceleration": _vector(spike, 0.0, 9.81),
            "angular_velocity": _vector(0.0, 0.0, 0.0),
            "orientation": quaternion,
        }
        add("imu", "/imu/data", "sensor_msgs/msg/Imu", stamp, fields)
    for number, _, stamp in every(50):
        fields = {
            **_header(stamp, "base_link", ros1=ros1),
            "name": list(JOINTS),
            "position": np.array([number * 0.1, number * 0.2]),
            "velocity": np.array([5.0, 10.0]),
            "effort": np.array([1.0, 2.0]),
        }
        add("joints", "/joint_states", "sensor_msgs/msg/JointState", stamp, fields)
    for _, _, stamp in every(2):
        add(
            "battery",
            "/battery_state",
            "sensor_msgs/msg/BatteryState",
            stamp,
            {**_header(stamp, "", ros1=ros1), "current": -4.0, "voltage": 24.0},
        )
    for _, _, stamp in every(10):
        add("command", "/cmd_vel", "geometry_msgs/msg/Twist", stamp, {"linear": _vector(1.0), "angular": _vector(0.0)})
        add("intervention", "/operator/intervention", "std_msgs/msg/Bool", stamp, {"data": False})
    return sorted(entries, key=lambda entry: entry[2])


@pytest.fixture(scope="session")
def drive_entries() -> Callable[..., list[Entry]]:
    """``drive_entries(seconds, seed=, streams=, ros1=, crash=)``: the messages of a short drive, in order of record."""
    return drive


@pytest.fixture(scope="session")
def labelled_dataset(tmp_path_factory: pytest.TempPathFactory, recording_writer: Callable[..., Path]) -> Path:
    """A labelled data set of three drives of six seconds in three places; read only."""
    folder = tmp_path_factory.mktemp("drives")
    paths = []
    for place in range(3):
        (folder / f"place-{place}").mkdir()
        paths.append(recording_writer(folder / f"place-{place}", "mcap", drive(6.0, seed=place), "run"))
    out = folder / "dataset"
    report = ingest(paths, out, RobotConfig(), IngestConfig(place="{parent}"))
    assert not report.quarantined, report.quarantined
    label_dataset(out, LabelConfig())
    return out
