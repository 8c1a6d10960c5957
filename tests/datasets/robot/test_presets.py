"""Every preset reads a recording with the topics and types of the robots that it is named after."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from noted import noted
from robot_factory import RobotDrive
from robot_messages import ANYMAL_JOINTS, DRAWN_A, OTHER_TYPES, SPEED_MPS, TURN_RADPS

from navtool.base.setting_error import SettingError
from navtool.cli.robots import ingest_job
from navtool.datasets.decode.vendor_state import UNITREE_JOINTS
from navtool.datasets.ingest.config import IngestConfig, Merge
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import Topic
from navtool.datasets.robot.config import JoyCommand, RobotConfig, TopicCandidates
from navtool.datasets.robot.topic_map import resolve_topic_map
from navtool.datasets.store.reader import NavDataset

PRESETS = sorted(path.stem for path in (Path(__file__).parents[3] / "configs" / "robot").glob("*.yaml"))
ROS2 = ("unitree_ros2", "spot_ros2", "clearpath_ros2", "turtlebot4", "go2")
STOPS = ("husky", "warthog", "rellis3d", "tartandrive1", "tartandrive2")
"""Presets whose interventions come from the robot's own state."""
JOINTS = {"anymal_grandtour": ANYMAL_JOINTS, "unitree_ros2": UNITREE_JOINTS}
"""Joints whose values, in the drives, are their places in this order."""


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_reads_the_recordings_of_its_robot(
    name: str, write_recording: Callable[..., Path], robot_drive: Callable[..., RobotDrive], tmp_path: Path
) -> None:
    robot, ros1 = ingest_job(name, []).robot, name not in ROS2
    entries, topics = robot_drive(name, robot, ros1=ros1)
    report = ingest([write_recording("ros1" if ros1 else "mcap", entries)], tmp_path / "out", robot, IngestConfig())
    assert report.quarantined == []
    episode = report.episodes[0]
    assert episode.topics == topics
    assert not any("cannot be decoded" in reason for reason in report.dropped)
    dataset = NavDataset(tmp_path / "out")
    assert dataset.column("valid.camera").all()
    if "lidar" in topics:
        assert dataset.calibration(0).base_lidar is not None
        assert dataset.column("valid.lidar")[2:].all()
        assert dataset.column("lidar.count")[2:].min() > 50
    if "battery" in topics:
        current = dataset.column("observation.proprioception")[5, -1]
        assert current == pytest.approx(DRAWN_A), "a discharging current is positive"
        guessed = bool(noted(episode.notes, "battery.sign-by-median"))
        assert guessed == (robot.battery_current_sign == 0)
    if name in STOPS:
        flag = dataset.stream(0, "intervention")
        assert flag is not None
        np.testing.assert_array_equal(flag["active"] > 0, flag["record_ns"] - flag["record_ns"][0] > 0.99e9)
    joints = JOINTS.get(name, tuple(robot.joint_names))
    if joints:
        names = dataset.features["observation.proprioception"].names
        assert names is not None
        assert names[: len(joints)] == tuple(f"position.{joint}" for joint in joints)
        position = dataset.column("observation.proprioception")[5, : len(joints)]
        np.testing.assert_allclose(position, np.arange(len(joints)), atol=1e-6)
    if "command" in topics:
        wanted = {"scand_jackal": (0.8, -0.7854), "scand_spot": (0.8, -0.7854)}.get(name)
        usual = (SPEED_MPS, TURN_RADPS) if (name, "command") in OTHER_TYPES else (1.0, 0.0)
        np.testing.assert_allclose(dataset.column("action")[8], wanted or usual, atol=1e-4)
        assert dataset.column("valid.action")[8]
    if (name, "camera") in OTHER_TYPES:
        red, green, blue = dataset.image(3).reshape(-1, 3).mean(axis=0)
        assert red > 2 * max(green, blue)
    if (name, "odometry") in OTHER_TYPES:
        pose, rows = dataset.column("observation.pose"), np.arange(3, len(dataset) - 3)
        np.testing.assert_allclose(pose[rows, 0], SPEED_MPS * 0.1 * rows, atol=1e-3)
        np.testing.assert_allclose(pose[rows][:, 1:], 0, atol=1e-5, err_msg="the pose runs along +x")
        np.testing.assert_allclose(dataset.column("observation.state")[rows, 0], SPEED_MPS, atol=1e-3)
    if name == "unitree_ros2":
        np.testing.assert_allclose(dataset.column("observation.imu")[5], [0, 0, 9.81, 0, 0, 0.5], atol=1e-5)


@pytest.mark.parametrize(
    ("name", "topic"),
    [
        ("jackal", "/rplidar/scan"),
        ("husky", "/front/scan"),
        ("musohu", "/scan"),
        ("clearpath_ros2", "/a200/sensors/lidar2d_0/scan"),
    ],
)
def test_a_planar_scanner_stands_in_for_the_lidar_that_a_robot_lacks(name: str, topic: str) -> None:
    scanner, robot = Topic(topic, "sensor_msgs/msg/LaserScan", 9), ingest_job(name, []).robot
    lidar = next(iter(robot.topics.lidar), "/velodyne_points")
    cloud = Topic(lidar if lidar.startswith("/") else f"/a200/{lidar}", "sensor_msgs/msg/PointCloud2", 9)
    assert resolve_topic_map(robot, [scanner]).topic_of("lidar") == topic
    assert resolve_topic_map(robot, [scanner, cloud]).topic_of("lidar") == cloud.name


def test_the_bags_of_a_mission_become_one_episode(
    recording_writer: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    missions = []
    for number in range(2):
        folder = tmp_path / f"mission-{number}"
        folder.mkdir()
        missions.append(folder)
        for part, streams in enumerate((("tf",), ("camera",), ("lidar", "imu"), ("odometry", "command", "joints"))):
            kind = "mcap" if part == 2 else "ros1"
            entries = drive_entries(2.0, seed=number, streams=streams, ros1=kind == "ros1")
            recording_writer(folder, kind, entries, f"part_{part}")
    apart = ingest([tmp_path], tmp_path / "apart", RobotConfig(), IngestConfig())
    assert len(apart.episodes) + len(apart.quarantined) == 8
    out = tmp_path / "out"
    report = ingest(missions, out, RobotConfig(), IngestConfig(merge=Merge.folder))
    assert [episode.source.rpartition("/")[2] for episode in report.episodes] == ["mission-0", "mission-1"]
    dataset = NavDataset(out)
    for stream in ("camera", "lidar", "state", "imu", "joints"):
        assert dataset.column(f"valid.{stream}")[2:18].all(), stream
    assert dataset.calibration(1).base_lidar is not None
    again = ingest([tmp_path / "mission-0"], out, RobotConfig(), IngestConfig(merge=Merge.folder))
    assert len(again.skipped) == 1


def test_a_joystick_without_meaning_is_told(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    axes = {"axes": np.zeros(6), "buttons": np.zeros(4, np.int32)}
    stamp = {"header": {"stamp": {"sec": 1_700_000_000, "nanosec": 0}}}
    joy = ("/joy", "sensor_msgs/msg/Joy", 1_700_000_000_000_000_000, {**stamp, **axes})
    path = write_recording("mcap", [joy, *drive_entries(streams=("camera", "odometry"))])
    topics = TopicCandidates(command=["/joy"])
    report = ingest([path], tmp_path / "out", RobotConfig(topics=topics), IngestConfig())
    assert report.dropped["command: cannot be decoded"] == 1
    assert "a joystick's axes have no meaning" in noted(report.episodes[0].notes, "stream.undecodable")[0]
    short = RobotConfig(topics=topics, joy=JoyCommand(forward_axis=9, forward_mps=1.0, turn_axis=0, turn_radps=1.0))
    report = ingest([path], tmp_path / "short", short, IngestConfig())
    assert report.dropped["command: cannot be decoded"] == 1
    with pytest.raises(SettingError, match="dead_zone"):
        JoyCommand(forward_axis=0, forward_mps=1.0, turn_axis=1, turn_radps=1.0, dead_zone=1.5)
