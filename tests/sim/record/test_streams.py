"""Recordings of a known drive: what stands in them, when, in which frames, in every format."""

import itertools
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from arc_drive import JOINTS, arc_drive
from jaxtyping import Float64
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from navtool.datasets.inspect.inspection import inspect_recording
from navtool.datasets.recording.identity import recording_sha256
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion
from navtool.sim.drive.drive import Drive
from navtool.sim.record.bag_format import BagFormat
from navtool.sim.record.messages import MessageFactory
from navtool.sim.record.recorder_config import CameraSetup, RecorderConfig
from navtool.sim.record.rig import CAMERA, LIDAR, RIGS, Rig, RobotKind
from navtool.sim.record.stage import Stage
from navtool.sim.record.streams import START_NS, TOPICS, TRUTH_IMAGE_TOPICS, Take, entries
from navtool.sim.sensors.lidar_config import LidarConfig, Returns
from navtool.sim.world.surfaces import SURFACES

SECONDS = 2.0
SMALL = CameraSetup(width=64, height=48)
POINT = np.dtype([("xyz", "<f4", 3), ("intensity", "<f4"), ("ring", "<u2"), ("time", "<f4")])
Messages = dict[str, list[tuple[int, Any]]]


@pytest.fixture(scope="module", params=list(BagFormat), ids=lambda kind: kind.name)
def recording(
    request: pytest.FixtureRequest, record: Callable[..., Path], tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, BagFormat]:
    return record(tmp_path_factory.mktemp(request.param.name), request.param, truth_images=True), request.param


@pytest.fixture(scope="module")
def messages(recording: tuple[Path, BagFormat]) -> Messages:
    return read(*recording)


@pytest.fixture(scope="module")
def drive(take_of: Callable[..., Take]) -> Drive:
    return take_of().drive


def read(path: Path, kind: BagFormat) -> Messages:
    """All messages of a recording, by the reader of the library."""
    found: Messages = {topic: [] for topic in {**TOPICS, **TRUTH_IMAGE_TOPICS}}
    store = get_typestore(Stores.ROS1_NOETIC if kind is BagFormat.ros1 else Stores.ROS2_HUMBLE)
    with AnyReader([path], default_typestore=store) as reader:
        assert {connection.topic: connection.msgtype for connection in reader.connections} == {
            **TOPICS,
            **TRUTH_IMAGE_TOPICS,
        }
        for connection, record_ns, data in reader.messages():
            found[connection.topic].append((record_ns, reader.deserialize(data, connection.msgtype)))
    return found


def stamp_ns(message: Any) -> int:
    return int(message.header.stamp.sec) * 10**9 + int(message.header.stamp.nanosec)


def matrix(pose: Any) -> Array:
    """The matrix of a Pose or a Transform."""
    xyz = getattr(pose, "position", None) or pose.translation
    q = getattr(pose, "orientation", None) or pose.rotation
    return transform_from_xyz_quaternion(np.array([xyz.x, xyz.y, xyz.z]), np.array([q.x, q.y, q.z, q.w]))


def test_counts_follow_the_rates(messages: Messages) -> None:
    counts = {topic: len(found) for topic, found in messages.items()}
    rates = {"/imu/data": 100, "/odom": 50, "/tf": 50, "/joint_states": 50, "/battery_state": 10, "/cmd_vel": 20}
    rates |= {"/operator/intervention": 10, "/ground_truth/odometry": 50}
    assert {topic: counts[topic] for topic in rates} == {topic: rate * SECONDS + 1 for topic, rate in rates.items()}
    once = ("/tf_static", "/ground_truth/obstacles", "/ground_truth/surfaces")
    assert [counts[topic] for topic in once] == [1, 1, 1]
    pictures = counts["/camera/front/image_raw/compressed"]
    assert 10 * SECONDS - 4 <= pictures <= 10 * SECONDS
    for topic in ("/camera/front/camera_info", "/ground_truth/segmentation", "/ground_truth/depth"):
        assert counts[topic] == pictures
    assert 10 * SECONDS - 5 <= counts["/velodyne_points"] <= 10 * SECONDS


def test_inspect_takes_the_sensors_and_leaves_the_truth(recording: tuple[Path, BagFormat], messages: Messages) -> None:
    found = inspect_recording(recording[0])
    assert {topic.name: topic.count for topic in found.topics} == {name: len(got) for name, got in messages.items()}
    assert not found.faults
    assert not found.topic_map.notes
    streams = found.topic_map.streams
    assert set(streams) == {
        *("camera", "camera_info", "lidar", "odometry", "imu", "joints", "battery", "command", "intervention")
    }
    unused = {topic.name: topic.reason for topic in found.topic_map.not_used}
    assert set(unused) == {topic for topic in messages if topic.startswith("/ground_truth/")}
    assert all(unused.values())


def test_headers_precede_the_recorder_by_a_plausible_delay(messages: Messages) -> None:
    for topic, found in messages.items():
        stamped = [(record_ns, stamp_ns(message)) for record_ns, message in found if hasattr(message, "header")]
        assert all(0 <= record_ns - stamp < 0.2e9 for record_ns, stamp in stamped), topic
        assert all(a[1] < b[1] for a, b in itertools.pairwise(sorted(stamped))), topic
        if stamped and not topic.startswith("/ground_truth"):
            assert all(record_ns > stamp for record_ns, stamp in stamped), topic


def test_frames_hang_together_as_rep_105_says(messages: Messages, drive: Drive) -> None:
    [(_, static)] = messages["/tf_static"]
    parents = {item.child_frame_id: (item.header.frame_id, matrix(item.transform)) for item in static.transforms}
    assert len(parents) == len(static.transforms), "a frame has one parent"
    rig = RIGS[RobotKind.wheeled]
    for frame in (CAMERA, LIDAR, "imu_link", "base_footprint"):
        pose, name = np.eye(4), frame
        while name != "base_link":
            name, step = parents[name]
            pose = step @ pose
        assert pose == pytest.approx(rig.mount(frame), abs=1e-12)
    assert rig.mount(CAMERA)[:3, 2] == pytest.approx([np.cos(0.35), 0, -np.sin(0.35)]), "looks ahead and down"
    assert rig.mount("base_footprint")[2, 3] == pytest.approx(-drive.position_m[0, 2]), "stands on the ground"
    assert parents["odom"][0] == "map"
    for _, moving in messages["/tf"]:
        (item,) = moving.transforms
        assert (item.header.frame_id, item.child_frame_id) == ("odom", "base_link")
        at = np.array([(stamp_ns(item) - START_NS) * 1e-9])  # the odometry of this drive has no errors
        assert parents["odom"][1] @ matrix(item.transform) == pytest.approx(drive.pose(at)[0], abs=1e-6)


def test_the_true_odometry_is_the_drive(messages: Messages, drive: Drive) -> None:
    for record_ns, message in messages["/ground_truth/odometry"]:
        assert (message.header.frame_id, message.child_frame_id) == ("map", "base_link")
        assert record_ns == stamp_ns(message)
        at = np.array([(record_ns - START_NS) * 1e-9])
        assert matrix(message.pose.pose) == pytest.approx(drive.pose(at)[0], abs=1e-6)
        assert message.twist.twist.linear.x == pytest.approx(0.8)
        assert message.twist.twist.angular.z == pytest.approx(0.3)


def depth_of_ground(camera: CameraModel, rig: Rig, base_height_m: float) -> Float64[Array, " w"]:
    """How far along the optical axis the bottom row of pixels sees level ground."""
    pixels = np.stack([np.arange(camera.width), np.full(camera.width, camera.height - 1)], axis=1).astype(np.float64)
    base_camera = rig.mount(CAMERA)
    down = -(camera.rays(pixels).directions @ base_camera[:3, :3].T)[:, 2]
    return np.asarray((base_height_m + base_camera[2, 3]) / down)


def test_pictures_and_their_truth_belong_together(messages: Messages, drive: Drive) -> None:
    names = json.loads(messages["/ground_truth/surfaces"][0][1].data)
    assert names == {**{str(i): surface.name for i, surface in enumerate(SURFACES)}, "255": "sky"}
    seen, true = ("image_raw/compressed", "camera_info"), ("segmentation", "depth")
    ground = 1000 * depth_of_ground(SMALL.model(), RIGS[RobotKind.wheeled], float(drive.position_m[0, 2]))
    four = [*(f"/camera/front/{name}" for name in seen), *(f"/ground_truth/{name}" for name in true)]
    for quadruple in zip(*(messages[topic] for topic in four), strict=True):
        assert len({stamp_ns(message) for _, message in quadruple}) == 1
        assert {message.header.frame_id for _, message in quadruple} == {CAMERA}
        picture, info, surfaces, depth = (message for _, message in quadruple)
        rgb = cv2.imdecode(picture.data, cv2.IMREAD_COLOR)
        assert rgb is not None
        assert rgb.shape == (48, 64, 3) == (info.height, info.width, 3)
        assert (surfaces.encoding, depth.encoding) == ("mono8", "16UC1")
        surface = surfaces.data.reshape(48, 64)
        millimetres = depth.data.view("<u2").reshape(48, 64)
        assert set(np.unique(surface).astype(str)) <= set(names)
        assert (millimetres[surface == 255] == 0).all()
        assert np.median(millimetres[-1] / ground) == pytest.approx(1.0, abs=0.02), "the ground before the robot"


def test_clouds_are_laid_out_as_their_fields_say(messages: Messages) -> None:
    for _, cloud in messages["/velodyne_points"]:
        named = [(field.name, field.offset) for field in cloud.fields]
        assert named == [("x", 0), ("y", 4), ("z", 8), ("intensity", 12), ("ring", 16), ("time", 18)]
        assert cloud.header.frame_id == LIDAR
        assert cloud.row_step * cloud.height == cloud.data.size == cloud.width * cloud.point_step
        points = np.frombuffer(cloud.data.tobytes(), POINT)
        assert len(points) > 8 * 1800 * 0.8
        assert set(points["ring"].tolist()) <= set(range(16))
        distance = np.linalg.norm(points["xyz"], axis=1)
        assert 0.45 < distance.min() <= distance.max() < 100.1
        assert -0.1 < points["time"].min() <= points["time"].max() <= 0


def test_joints_battery_and_commands_arrive_as_measured(messages: Messages, drive: Drive) -> None:
    for (_, message), sample in zip(messages["/joint_states"], drive.joints.values, strict=True):
        assert tuple(message.name) == JOINTS
        np.testing.assert_allclose([message.position, message.velocity, message.effort], sample)
    assert all(m.current == pytest.approx(-3.0) for _, m in messages["/battery_state"])
    assert all((m.twist.linear.x, m.twist.angular.z) == (0.8, 0.3) for _, m in messages["/cmd_vel"])


def test_events_are_recorded_when_they_end(messages: Messages, drive: Drive) -> None:
    events = [(record_ns, json.loads(message.data)) for record_ns, message in messages["/ground_truth/event"]]
    for (record_ns, event), failure in zip(events, drive.failures, strict=True):
        assert (event["kind"], event["reason"]) == (failure.kind.value, failure.reason)
        assert (event["start_s"], event["end_s"]) == (failure.start_s, failure.end_s)
        assert event["start_ns"] == START_NS + round(failure.start_s * 1e9)
        assert event["end_ns"] == record_ns == START_NS + round(failure.end_s * 1e9)
        assert (event["x_m"], event["y_m"]) == (failure.x_m, failure.y_m)


def test_obstacles_are_outlined_where_they_stand(messages: Messages, stage: Stage) -> None:
    found = json.loads(messages["/ground_truth/obstacles"][0][1].data)["obstacles"]
    classes = {"trunk": "solid", "wall": "solid", "glass": "transparent", "grass_patch": "pliable"}
    assert {item["kind"]: item["class"] for item in found} == classes
    for item, obstacle in zip(found, stage.world.obstacles.items, strict=True):
        x, y = np.array(item["outline_m"]).T
        area = 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())
        assert area > 0, "counter-clockwise"
        only = type(stage.world.obstacles)((obstacle,))
        np.testing.assert_allclose(only.clearance(x, y), 0.0, atol=1e-3)


def test_the_terrain_underneath_is_reported_at_each_change(messages: Messages, stage: Stage, drive: Drive) -> None:
    told = [json.loads(message.data) for _, message in messages["/ground_truth/terrain"]]
    assert all(a["surface"] != b["surface"] for a, b in itertools.pairwise(told))
    assert told[0]["stamp_ns"] == START_NS
    for moment in np.arange(0.0, SECONDS, 0.1):
        x, y = drive.pose(np.array([moment]))[:, :2, 3].T
        under = SURFACES[int(stage.world.ground.surface_at(x, y)[0])]
        stamp = START_NS + moment * 1e9
        last = [change for change in told if change["stamp_ns"] <= stamp + 1e3][-1]
        assert (last["surface"], last["group"]) == (under.name, under.group.value)


@pytest.mark.parametrize("kind", list(BagFormat), ids=lambda kind: kind.name)
def test_equal_takes_give_equal_bytes_and_other_seeds_do_not(
    kind: BagFormat, record: Callable[..., Path], tmp_path: Path
) -> None:
    brief = arc_drive(0.5)
    paths = [record(tmp_path / name, kind, drive=brief, seed=seed) for name, seed in (("a", 1), ("b", 1), ("c", 2))]
    a, b, c = (recording_sha256(path) for path in paths)
    assert a == b
    assert a != c
    assert [path.name for path in (tmp_path / "a").iterdir()] == [paths[0].name], "nothing else is left"


def test_a_recorder_can_lose_and_delay(take_of: Callable[..., Take]) -> None:
    def told(config: RecorderConfig) -> list[tuple[int, str]]:
        take = take_of(recorder=config, drive=arc_drive(1.5))
        return [(entry.record_ns, entry.topic) for entry in entries(take, MessageFactory(ros1=False))]

    def count(found: list[tuple[int, str]], topic: str) -> int:
        return sum(name == topic for _, name in found)

    whole, lossy = told(RecorderConfig(drop_share=0.0, delay=0.0)), told(RecorderConfig(drop_share=0.5, delay=5.0))
    assert whole == sorted(whole, key=lambda pair: pair[0])
    assert count(whole, "/velodyne_points") == 14
    assert 0 < count(lossy, "/velodyne_points") < 14
    assert count(lossy, "/imu/data") == count(whole, "/imu/data"), "only pictures and clouds get lost"
    late = next(record_ns for record_ns, topic in lossy if topic == "/imu/data")
    assert 7.5e6 <= late - START_NS < 100e6


def test_dual_returns_are_points_too(record: Callable[..., Path], tmp_path: Path) -> None:
    brief = arc_drive(0.4)
    counts = []
    for returns in (Returns.strongest, Returns.dual):
        path = record(tmp_path / returns.name, drive=brief, lidar=LidarConfig(returns=returns))
        with AnyReader([path]) as reader:
            wanted = [c for c in reader.connections if c.topic == "/velodyne_points"]
            clouds: list[Any] = [reader.deserialize(data, c.msgtype) for c, _, data in reader.messages(wanted)]
        counts.append(sum(cloud.width for cloud in clouds))
    assert counts[1] > counts[0] > 0
