"""A recording composed out of real pieces: no small public one has outdoor images, clouds and odometry together.

Camera and LiDAR frames are RELLIS-3D's (one scene) and photos of an ANYmal's and a forest trail; odometry and IMU are a
Husky's outdoors; joints are a Go2's. Each keeps its own values; only the time stamps are laid onto one clock.
"""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import yaml
from rosbags.highlevel import AnyReader
from scipy.spatial.transform import Rotation

Entry = tuple[str, str, int, dict[str, Any]]
START_NS = 1_581_624_663_000_000_000
JOINTS = tuple(f"{leg}_{joint}" for leg in ("FR", "FL", "RR", "RL") for joint in ("hip", "thigh", "calf"))
PHOTOS = (
    "photos/anymal_wvn/forest_grass.png",
    "photos/utadl_forest/forest1.jpg",
    "photos/anymal_wvn/mountain_bike_trail_raw.png",
    "photos/utadl_forest/forest2.jpg",
)
"""Frames between the RELLIS-3D ones."""
WIDTH, HEIGHT = 1920, 1200


@pytest.fixture(scope="session")
def composed_entries(recordings: Path) -> Callable[..., list[Entry]]:
    """``composed_entries(first_s, seconds, ros1=False)``: a cut of the composed drive, in order of record."""

    def entries(first_s: float, seconds: float, *, ros1: bool = False) -> list[Entry]:
        made: list[Entry] = []
        for topic, kind, time_ns, frame, fields in (
            *_camera(recordings, seconds),
            *_lidar(recordings, seconds),
            *_husky(recordings, first_s, seconds),
            *_joints(recordings, seconds),
        ):
            stamp = {"sec": time_ns // 10**9, "nanosec": time_ns % 10**9}
            header = {"stamp": stamp, "frame_id": frame, **({"seq": 0} if ros1 else {})}
            made.append((topic, kind, time_ns + 4_000_000, {"header": header, **fields}))
        return [_mounting(recordings, ros1=ros1), *sorted(made, key=lambda entry: entry[2])]

    return entries


Piece = tuple[str, str, int, str, dict[str, Any]]


def _camera(folder: Path, seconds: float) -> Iterator[Piece]:
    rellis = cv2.imread(str(next((folder / "lidar" / "rellis3d").glob("frame*.jpg"))))
    photos = [cv2.imread(str(folder / name)) for name in PHOTOS]
    assert rellis is not None
    frames = [rellis, *(cv2.resize(photo, (WIDTH, HEIGHT)) for photo in photos if photo is not None)]
    assert len(frames) == 1 + len(PHOTOS)
    jpegs = [cv2.imencode(".jpg", frame, [cv2.IMWRITE_JPEG_QUALITY, 60])[1].ravel() for frame in frames]
    fx, fy, cx, cy = (float(value) for value in (folder / "lidar/rellis3d/camera_info.txt").read_text().split()[:4])
    intrinsics = {
        "width": WIDTH,
        "height": HEIGHT,
        "distortion_model": "plumb_bob",
        "d": np.zeros(5),
        "k": np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1]),
        "r": np.eye(3).ravel(),
        "p": np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0]),
    }
    yield "/pylon_camera_node/camera_info", "sensor_msgs/msg/CameraInfo", START_NS, "camera", intrinsics
    for number in range(int(seconds * 10)):
        # one scene for a second at a time; each frame is a real one
        fields = {"format": "jpeg", "data": jpegs[(number // 10) % len(jpegs)]}
        time_ns = START_NS + number * 100_000_000
        yield "/pylon_camera_node/image_raw/compressed", "sensor_msgs/msg/CompressedImage", time_ns, "camera", fields


def _lidar(folder: Path, seconds: float) -> Iterator[Piece]:
    cloud = np.fromfile(folder / "lidar/rellis3d/000104.bin", dtype="<f4").reshape(-1, 4)
    fields = [{"name": name, "offset": 4 * place, "datatype": 7, "count": 1} for place, name in enumerate("xyz")]
    fields.append({"name": "intensity", "offset": 12, "datatype": 7, "count": 1})
    for number in range(int(seconds * 10)):
        # every eighth point, from a beam that moves on: neighbouring sweeps differ as they would
        thinned = np.ascontiguousarray(cloud[number % 8 :: 8])
        message = {
            "height": 1,
            "width": len(thinned),
            "fields": fields,
            "point_step": 16,
            "row_step": 16 * len(thinned),
            "data": np.frombuffer(thinned.tobytes(), np.uint8),
            "is_dense": True,
        }
        time_ns = START_NS + 30_000_000 + number * 100_000_000
        yield "/os1_cloud_node/points", "sensor_msgs/msg/PointCloud2", time_ns, "os1_lidar", message


def _husky(folder: Path, first_s: float, seconds: float) -> Iterator[Piece]:
    names = {"/husky_velocity_controller/odom": "nav_msgs/msg/Odometry", "/imu/data": "sensor_msgs/msg/Imu"}
    with AnyReader([folder / "bags/husky_outdoor/test1.bag"]) as reader:
        chosen = [connection for connection in reader.connections if connection.topic in names]
        begin = reader.start_time + round(first_s * 1e9)
        for connection, record_ns, raw in reader.messages(chosen, begin, begin + round(seconds * 1e9)):
            message: Any = reader.deserialize(raw, connection.msgtype)
            time_ns = START_NS + record_ns - begin
            yield connection.topic, names[connection.topic], time_ns, message.header.frame_id, _fields(message)


def _fields(message: Any) -> dict[str, Any]:
    """The message's fields as the factory wants them, the header left out."""
    found: dict[str, Any] = {}
    for name in message.__dataclass_fields__:
        value = getattr(message, name)
        if name not in ("header", "__msgtype__"):
            found[name] = _fields(value) if hasattr(value, "__dataclass_fields__") else value
    return found


def _joints(folder: Path, seconds: float) -> Iterator[Piece]:
    log = np.loadtxt(next((folder / "proprio/unitree_go2/test_1").glob("state_history.csv")), delimiter=",")
    rows = log[: int(seconds * 500) : 10]
    assert (np.diff(rows[:, 0]) > 0).all()
    for row in rows:
        time_ns = START_NS + int(row[0] - rows[0, 0])
        fields = {"name": list(JOINTS), "position": row[1:13], "velocity": row[13:25], "effort": row[25:37]}
        yield "/joint_states", "sensor_msgs/msg/JointState", time_ns, "base_link", fields


def _mounting(folder: Path, *, ros1: bool) -> Entry:
    """The camera's pose in the LiDAR's frame as RELLIS-3D gives it; the LiDAR 0.8 m above the base, as on a Warthog."""
    given = yaml.safe_load((folder / "lidar/rellis3d/transforms.yaml").read_text())
    pose = given[next(iter(given))]
    rotation = Rotation.from_quat([pose["q"][axis] for axis in "xyzw"])
    shift = [pose["t"][axis] for axis in "xyz"]
    transforms = []
    # Ouster's lidar frame looks backwards, towards its connector, and so does the camera in it
    backwards = Rotation.from_euler("z", 180, degrees=True)
    mounts = (("base_link", "os1_lidar", [0, 0, 0.8], backwards), ("os1_lidar", "camera", shift, rotation))
    for parent, child, xyz, turn in mounts:
        stamp = {"sec": START_NS // 10**9, "nanosec": 0}
        header = {"stamp": stamp, "frame_id": parent, **({"seq": 0} if ros1 else {})}
        quaternion = {axis: float(value) for axis, value in zip("xyzw", turn.as_quat(), strict=True)}
        where = {"translation": dict(zip("xyz", map(float, xyz), strict=True)), "rotation": quaternion}
        transforms.append({"header": header, "child_frame_id": child, "transform": where})
    return "/tf_static", "tf2_msgs/msg/TFMessage", START_NS, {"transforms": transforms}
