import hashlib
import itertools
import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from navtool.datasets.recording.raw import RecordingFormat
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion
from navtool.sim.bags import SUFFIX, TOPICS, TakeConfig, write_recording
from navtool.sim.errors import SimError
from navtool.sim.rig import RigConfig, mount
from navtool.sim.scene import Scene
from navtool.sim.track import Track, drive

SECONDS = 4.0
STORES = {
    RecordingFormat.ros1: Stores.ROS1_NOETIC,
    RecordingFormat.ros2_db3: Stores.ROS2_HUMBLE,
    RecordingFormat.mcap: Stores.ROS2_HUMBLE,
}
Write = Callable[..., Path]


@pytest.fixture(scope="module")
def stage(place: Scene) -> tuple[Scene, Track]:
    """A drive that fails early, and the place with only what stands near the way."""
    for seed in range(100):
        track = drive(place, seed, SECONDS, mischief=1.0)
        if track.failures and track.failures[0].end_s < SECONDS - 0.5:
            way = np.stack([track.x_m, track.y_m])
            return replace(place, things=tuple(t for t in place.things if t.shape.clearance(way).min() < 4.0)), track
    raise AssertionError("no drive with an early failure")


@pytest.fixture(scope="module")
def write(stage: tuple[Scene, Track]) -> Write:
    """A factory of recordings of that drive."""

    def make(
        folder: Path, *, storage: RecordingFormat = RecordingFormat.mcap, name: str = "run", seed: int = 3
    ) -> Path:
        config = TakeConfig(seed=seed, rig=RigConfig(width=64))
        return write_recording(folder / f"{name}{SUFFIX[storage]}", *stage, config, storage=storage)

    return make


@pytest.fixture(scope="module", params=list(RecordingFormat), ids=str)
def recording(
    request: pytest.FixtureRequest, write: Write, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, RecordingFormat]:
    return write(tmp_path_factory.mktemp(request.param), storage=request.param), request.param


def read(path: Path, storage: RecordingFormat) -> dict[str, list[tuple[int, Any]]]:
    messages: dict[str, list[tuple[int, Any]]] = {topic: [] for topic in TOPICS}
    store = get_typestore(STORES[storage])
    with AnyReader([path], default_typestore=store) as reader:
        assert {connection.topic: connection.msgtype for connection in reader.connections} == TOPICS
        for connection, record_ns, data in reader.messages():
            messages[connection.topic].append((record_ns, reader.deserialize(data, connection.msgtype)))
    return messages


def stamp_ns(message: Any) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)


def digest(path: Path) -> dict[str, str]:
    files = [path] if path.is_file() else sorted(path.iterdir())
    return {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in files}


def test_a_recording_opens_with_the_counts_of_its_rates(
    recording: tuple[Path, RecordingFormat], stage: tuple[Scene, Track]
) -> None:
    counts = {topic: len(messages) for topic, messages in read(*recording).items()}
    exact = {
        "/imu/data": 100,
        "/odom": 50,
        "/joint_states": 50,
        "/cmd_vel": 20,
        "/battery_state": 10,
        "/operator/intervention": 10,
    }
    assert {topic: counts[topic] for topic in exact} == {topic: rate * SECONDS for topic, rate in exact.items()}
    assert counts["/tf_static"] == 1
    assert counts["/ground_truth/event"] == len(stage[1].failures)
    assert counts["/camera/front/camera_info"] == counts["/camera/front/image_raw/compressed"]
    assert 15 * SECONDS - 5 <= counts["/camera/front/image_raw/compressed"] <= 15 * SECONDS + 1
    assert 10 * SECONDS - 5 <= counts["/velodyne_points"] <= 10 * SECONDS


def test_headers_precede_the_recorder_by_a_plausible_delay(recording: tuple[Path, RecordingFormat]) -> None:
    for topic, messages in read(*recording).items():
        for record_ns, message in messages:
            if hasattr(message, "header"):
                assert 0 < record_ns - stamp_ns(message) < 0.2e9, topic
        stamps = [stamp_ns(message) for _, message in messages if hasattr(message, "header")]
        assert all(first < second for first, second in itertools.pairwise(stamps)), topic


def test_images_and_clouds_decode_to_what_their_headers_say(recording: tuple[Path, RecordingFormat]) -> None:
    messages = read(*recording)
    _, image = messages["/camera/front/image_raw/compressed"][0]
    picture = cv2.imdecode(image.data, cv2.IMREAD_COLOR)
    assert picture is not None
    assert picture.shape == (48, 64, 3)
    assert image.header.frame_id == "camera_front_optical"
    _, cloud = messages["/velodyne_points"][0]
    assert [field.name for field in cloud.fields] == ["x", "y", "z", "intensity", "ring", "time"]
    assert cloud.row_step * cloud.height == cloud.data.size == cloud.width * cloud.point_step
    points = np.frombuffer(
        cloud.data.tobytes(),
        np.dtype([("xyz", "<f4", 3), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")]),
    )
    assert len(points) > 8 * 1800 * 0.8
    assert set(points["ring"].tolist()) <= set(range(16))
    distance = np.linalg.norm(points["xyz"], axis=1)
    assert distance.min() > 0.3
    assert distance.max() < 100.1
    assert points["time"].min() > -0.1
    assert points["time"].max() <= 0


def test_static_transforms_give_the_mounts(recording: tuple[Path, RecordingFormat]) -> None:
    [(_, message)] = read(*recording)["/tf_static"]
    parents = {}
    for item in message.transforms:
        xyz, q = item.transform.translation, item.transform.rotation
        matrix = transform_from_xyz_quaternion(np.array([xyz.x, xyz.y, xyz.z]), np.array([q.x, q.y, q.z, q.w]))
        parents[item.child_frame_id] = (item.header.frame_id, matrix)
    for frame in ("base_link", "velodyne", "imu_link", "camera_front_optical"):
        pose, name = np.eye(4), frame
        while name != "base_footprint":
            name, step = parents[name]
            pose = step @ pose
        assert pose == pytest.approx(mount(frame), abs=1e-12)
    assert mount("base_link")[2, 3] == pytest.approx(0.15)
    assert mount("camera_front_optical")[:3, 2] == pytest.approx([np.cos(0.1), 0, -np.sin(0.1)]), "looks ahead and down"


def test_events_are_the_truth_of_the_drive(recording: tuple[Path, RecordingFormat], stage: tuple[Scene, Track]) -> None:
    messages = read(*recording)
    events = [json.loads(message.data) for _, message in messages["/ground_truth/event"]]
    start_ns = TakeConfig().start_ns
    assert [event["reason"] for event in events] == [failure.reason for failure in stage[1].failures]
    for event, failure in zip(events, stage[1].failures, strict=True):
        assert event["outcome"] == 0
        assert event["start_ns"] == pytest.approx(start_ns + failure.start_s * 1e9, abs=1e3)
        assert event["end_ns"] == pytest.approx(start_ns + failure.end_s * 1e9, abs=1e3)
        odometry = [m for _, m in messages["/odom"] if event["start_ns"] + 2e8 < stamp_ns(m) < event["start_ns"] + 8e8]
        assert max(abs(m.twist.twist.linear.x) for m in odometry) < 0.1, "the robot stands in it"


def test_equal_seeds_give_equal_bytes_and_others_do_not(
    recording: tuple[Path, RecordingFormat], write: Write, tmp_path: Path
) -> None:
    path, storage = recording
    again = write(tmp_path / "again", storage=storage)
    assert digest(again) == digest(path)
    assert sorted(file.name for file in (tmp_path / "again").iterdir()) == [path.name], "nothing else is left"
    other = write(tmp_path / "other", storage=storage, seed=4)
    assert digest(other) != digest(path)


def test_what_is_there_already_is_left_alone(write: Write, tmp_path: Path) -> None:
    (tmp_path / "run.mcap").write_text("mine")
    with pytest.raises(SimError, match="something is there already"):
        write(tmp_path)
    assert (tmp_path / "run.mcap").read_text() == "mine"


def test_a_name_that_lies_about_its_format_is_refused(stage: tuple[Scene, Track], tmp_path: Path) -> None:
    with pytest.raises(SimError, match=r"end it in \.bag"):
        write_recording(tmp_path / "run.mcap", *stage, TakeConfig(), storage=RecordingFormat.ros1)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_named(stage: tuple[Scene, Track], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(SimError, match="cannot write a recording"):
        write_recording(tmp_path / "file" / "run.mcap", *stage, TakeConfig())


@pytest.mark.parametrize("wrong", [{"width": 8}, {"camera_hz": 0.0}, {"jpeg_quality": 0}, {"drop_share": 0.9}])
def test_a_rig_out_of_range_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match="need "):
        RigConfig(**wrong)
