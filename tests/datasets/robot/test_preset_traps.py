"""The traps of known robots' recordings: point layouts, sweeps stamped at their end, times, namespaces, joint names."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from noted import noted
from robot_factory import RobotDrive
from robot_messages import (
    ANYMAL_JOINTS,
    POINTS,
    SPEED_MPS,
    SWEEP_S,
    Make,
    hesai,
    livox,
    ouster,
    ouster_of_2020,
    velodyne_stamped_at_the_end,
    xyz_alone,
)

from navtool.cli.robots import ingest_job
from navtool.datasets.decode.messages import Decoded
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import EpisodeSummary
from navtool.datasets.recording import RawMessage, Recording, open_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.topic_map import resolve_topic_map
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.first_pass import first_pass

ROS2 = ("unitree_ros2", "spot_ros2", "clearpath_ros2", "turtlebot4", "go2")
SHARE = np.arange(POINTS) / POINTS
CLOUD = "sensor_msgs/msg/PointCloud2"
type Ingested = tuple[NavDataset, EpisodeSummary]
type Drive = Callable[..., RobotDrive]


@pytest.fixture
def ingested(write_recording: Callable[..., Path], tmp_path: Path) -> Callable[..., Ingested]:
    """``ingested(robot, entries, name="out", ros1=True, **config)``: the data set and its one episode."""

    def run(robot: RobotConfig, entries: list[Any], name: str = "out", *, ros1: bool = True, **config: Any) -> Ingested:
        path = write_recording("ros1" if ros1 else "mcap", entries, f"bag-{name}")
        report = ingest([path], tmp_path / name, robot, IngestConfig(**config))
        assert report.quarantined == []
        return NavDataset(tmp_path / name), report.episodes[0]

    return run


@pytest.mark.parametrize(
    ("preset", "topic", "make", "time_s", "ring"),
    [
        ("rellis3d", "/os1_cloud_node/points", ouster_of_2020, SHARE * SWEEP_S, np.arange(POINTS) % 64),
        ("fusionportable_v2", "/os_cloud_node/points", ouster, SHARE * SWEEP_S, np.arange(POINTS) % 128),
        ("m2dgr", "/velodyne_points", velodyne_stamped_at_the_end, (SHARE - 1) * SWEEP_S, np.arange(POINTS) % 32),
        ("musohu", "/velodyne_points", velodyne_stamped_at_the_end, (SHARE - 1) * SWEEP_S, np.arange(POINTS) % 32),
        ("anymal_grandtour", "/boxi/hesai/points", hesai, SHARE * SWEEP_S, np.arange(POINTS) % 32),
        ("anymal_grandtour", "/boxi/livox/points", livox, SHARE * SWEEP_S, np.arange(POINTS) % 4),
        ("spot_ros1", "/spot/lidar/points", xyz_alone, None, None),
    ],
)
def test_the_points_of_each_lidar_have_their_times_and_lasers(
    preset: str, topic: str, make: Make, time_s: Any, ring: Any, robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    robot = ingest_job(preset, []).robot
    drive = robot_drive(preset, robot, 1.0, ros1=True, other_types={"lidar": (CLOUD, make)}, streams=("lidar", "tf"))
    usual = drive.topics["lidar"]
    entries = [(topic if name == usual else name, *rest) for name, *rest in drive.entries]
    dataset, episode = ingested(robot, entries)
    assert episode.topics["lidar"] == topic
    clouds = list(dataset.clouds(0))
    assert len(clouds) == 10
    for cloud in clouds:
        assert len(cloud.xyz) == POINTS
        assert cloud.record_ns - cloud.stamp_ns == 3_000_000, "the header's stamp counts, whichever end it marks"
        for found, wanted, within in ((cloud.time_s, time_s, 1e-6), (cloud.ring, ring, 0)):
            assert (found is None) == (wanted is None)
            if found is not None:
                np.testing.assert_allclose(found, wanted, atol=within)


@pytest.mark.parametrize("make", [velodyne_stamped_at_the_end, hesai], ids=["stamped at the end", "at the start"])
def test_clouds_are_compensated_towards_their_stamp(
    make: Make, robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    """The robot drives along +x at 1 m/s: a point that was measured earlier moves backwards, a later one forwards."""
    robot = ingest_job("generic", []).robot
    streams = ("lidar", "odometry", "tf")
    drive = robot_drive("generic", robot, 2.0, ros1=False, other_types={"lidar": (CLOUD, make)}, streams=streams)
    still, _ = ingested(robot, drive.entries, "still", ros1=False, voxel_m=0.001)
    moved, _ = ingested(robot, drive.entries, "moved", ros1=False, voxel_m=0.001, deskew=True)
    shift = (SHARE - 1) * SWEEP_S if make is velodyne_stamped_at_the_end else SHARE * SWEEP_S
    angle = np.linspace(-np.pi, np.pi, POINTS, endpoint=False)
    row = 5
    for dataset, by_m in ((still, 0.0), (moved, shift)):
        points = dataset.points(row)[: dataset.column("lidar.count")[row]].astype(np.float64)
        xyz = np.column_stack([8 * np.cos(angle) + by_m, 8 * np.sin(angle), np.linspace(-0.5, 1, POINTS) + 0.6])
        in_front = xyz[xyz[:, 0] >= 0]
        assert len(points) == len(in_front)
        np.testing.assert_allclose(np.sort(points[:, 0]), np.sort(in_front[:, 0]), atol=2e-3)


def test_an_anymals_joints_come_at_400_hz_by_their_actuators(
    robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    robot = ingest_job("anymal_grandtour", []).robot
    drive = robot_drive("anymal_grandtour", robot, 2.0, ros1=True, streams=("odometry", "tf"))
    names = list(reversed(ANYMAL_JOINTS))
    fast = []
    for number in range(800):
        stamp_ns = 1_700_000_000_000_000_000 + number * 2_500_000
        header = {"seq": number, "stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": "base"}
        values = {"position": np.arange(12.0) + number / 400, "velocity": np.ones(12), "effort": np.arange(12.0)}
        fields = {"header": header, "joints": {"header": header, "name": names, **values}}
        fast.append((robot.topics.joints[0], "anymal_msgs/msg/AnymalState", stamp_ns + 1_000_000, fields))
    dataset, _ = ingested(robot, sorted([*drive.entries, *fast], key=lambda entry: entry[2]))
    features = dataset.features["observation.proprioception"].names
    assert features is not None
    assert list(features[:12]) == [f"position.{name}" for name in names], "the message's order, by its names"
    rows = np.arange(1, 19)
    position = dataset.column("observation.proprioception")[rows, :12]
    np.testing.assert_allclose(position, np.arange(12.0) + 0.1 * rows[:, None], atol=1e-5)
    native = dataset.stream(0, "joints")
    assert native is not None
    assert len(native["stamp_ns"]) == 800
    assert (np.diff(native["stamp_ns"]) == 2_500_000).all()


@pytest.mark.parametrize(
    ("preset", "headless"),
    [
        ("rellis3d", {"command"}),
        ("tartandrive1", {"intervention"}),
        ("tartandrive2", {"intervention", "command"}),
        ("fusionportable_v2", {"battery", "intervention"}),
        ("unitree_ros2", {"imu", "joints", "battery", "intervention"}),
        ("clearpath_ros2", {"command", "intervention"}),
    ],
)
def test_types_without_a_header_count_by_their_time_of_record(
    preset: str, headless: set[str], robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    robot, ros1 = ingest_job(preset, []).robot, preset not in ROS2
    drive = robot_drive(preset, robot, 1.0, ros1=ros1)
    dataset, episode = ingested(robot, drive.entries, ros1=ros1)
    told = {text.partition(":")[0] for text in noted(episode.notes, "clock.record-time") if "no header" in text}
    assert told == headless
    for stream in set(drive.topics) - {"camera", "camera_info", "lidar"}:
        native = dataset.stream(0, stream)
        assert native is not None
        delay_ns = native["record_ns"] - native["stamp_ns"]
        assert (delay_ns == (0 if stream in headless else 3_000_000)).all(), stream


def test_a_message_that_feeds_three_streams_is_decoded_once(
    robot_drive: Drive, write_recording: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = ingest_job("unitree_ros2", []).robot
    drive = robot_drive("unitree_ros2", robot, 1.0, ros1=False, streams=("imu", "joints", "battery", "odometry"))
    decoded: list[RawMessage] = []
    decode = Recording.decode

    def counted(recording: Recording, raw: RawMessage) -> Decoded:
        decoded.append(raw)
        return decode(recording, raw)

    monkeypatch.setattr(Recording, "decode", counted)
    with open_recording(write_recording("mcap", drive.entries)) as recording:
        found = first_pass(recording, resolve_topic_map(robot, recording.topics), ())
    assert len(decoded) == len(drive.entries)
    assert [len(found.streams[name].values()) for name in ("imu", "joints", "battery")] == [100, 100, 100]


@pytest.mark.parametrize("preset", ROS2)
def test_a_namespace_before_every_topic_changes_nothing(
    preset: str, robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    robot = ingest_job(preset, []).robot
    datasets = []
    for number, namespace in enumerate(("", "/fleet/r1")):
        drive = robot_drive(preset, robot, 1.0, ros1=False, namespace=namespace)
        named = {stream for stream in drive.topics if getattr(robot.topics, stream)}
        assert named
        assert all(drive.topics[stream].startswith(f"{namespace}/") for stream in named)
        dataset, episode = ingested(robot, drive.entries, f"out-{number}", ros1=False)
        assert episode.topics == drive.topics
        datasets.append(dataset)
    for one, other in pairwise(datasets):
        assert one.features == other.features
        assert one.calibration(0) is not None
        for key, feature in one.features.items():
            if feature.dtype != "video" and len(feature.shape) == 1:
                np.testing.assert_array_equal(one.column(key), other.column(key), err_msg=key)
        np.testing.assert_array_equal(one.image(5), other.image(5))


def test_a_drives_current_stands_in_where_the_robot_tells_no_other(
    robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    robot = ingest_job("rellis3d", []).robot
    drive = robot_drive("rellis3d", robot, 1.0, ros1=True)
    left, right = (f"/{side}_drive/status/battery_current" for side in ("left", "right"))
    entries = []
    for topic, kind, record_ns, fields in drive.entries:
        if topic != drive.topics["battery"]:
            entries.append((topic, kind, record_ns, fields))
        else:
            entries += [(name, "std_msgs/msg/Float64", record_ns, {"data": 6.5}) for name in (left, right)]
    dataset, episode = ingested(robot, entries)
    assert episode.topics["battery"] == left
    assert "intervention" not in episode.topics
    assert dataset.column("observation.proprioception")[5, -1] == 6.5
    assert (right, "read as battery only where the robot file names it") in [
        (entry["name"], entry["reason"]) for entry in episode.not_used
    ]


def test_a_state_without_a_battery_leaves_it_out_and_says_so(
    robot_drive: Drive, write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    """The layout of an A1, which has a header, joints and IMU, but no battery."""
    robot = ingest_job("fusionportable_v2", []).robot
    drive = robot_drive("fusionportable_v2", robot, 1.0, ros1=True)
    kind = "unitree_legged_msgs/msg/HighState"
    layout = "std_msgs/Header header\nunitree_legged_msgs/IMU imu\nunitree_legged_msgs/MotorState[20] motorState"
    entries = [entry for entry in drive.entries if entry[0] != drive.topics["joints"]]
    path = write_recording("ros1", entries, types=((kind, layout),))
    report = ingest([path], tmp_path / "out", robot, IngestConfig())
    states = sum(entry[1] == kind for entry in entries)
    assert report.dropped["battery: cannot be decoded"] == states
    (note,) = noted(report.episodes[0].notes, "stream.undecodable")
    assert note.endswith("on /unitree/robot_state can be decoded: the message holds no battery")
    names = NavDataset(tmp_path / "out").features["observation.proprioception"].names
    assert names is not None
    assert names[0] == "position.FR_hip_joint", "the vendor's joints stand in for the missing joint states"


def test_the_odometry_of_a_tartandrive_without_gps_is_told_of(
    robot_drive: Drive, ingested: Callable[..., Ingested]
) -> None:
    """Whether its poses need the quarter turn is not known; a drive of more than 5 m shows it."""
    robot = ingest_job("tartandrive2", []).robot

    def straight(header: dict[str, Any], time_s: float) -> dict[str, Any]:
        pose = {"position": {"x": SPEED_MPS * time_s}, "orientation": {"w": 1.0}}
        twist = {"linear": {"x": SPEED_MPS}}
        return {**header, "child_frame_id": "vehicle", "pose": {"pose": pose}, "twist": {"twist": twist}}

    made = {"odometry": ("nav_msgs/msg/Odometry", straight)}
    for other_types, told in ((None, False), (made, True)):
        drive = robot_drive("tartandrive2", robot, 9.0, ros1=True, other_types=other_types, streams=("odometry",))
        entries = [("/superodometry/integrated_to_init", *rest) for _, *rest in drive.entries]
        _, episode = ingested(robot, entries, f"out-{told}")
        assert bool(noted(episode.notes, "odometry.moves-aside")) == told
