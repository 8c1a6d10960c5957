"""Inspection: the known counts of real recordings, and rates, gaps and clocks of written ones."""

import json
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_typestore

from navtool.base.errors import DatasetsError
from navtool.datasets.inspect.inspection import TopicReport, inspect_recording, robot_from
from navtool.datasets.robot.config import RobotConfig, TopicCandidates

SECOND = 1_000_000_000


def write_imu_bag(path: Path, stamps: Sequence[tuple[int, int]]) -> Path:
    """A ROS 1 bag with ``/imu`` of (record time, header stamp) in ns, and a Bool without header beside each."""
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    with Writer(path) as writer:
        imu = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
        stop = writer.add_connection("/e_stop", "std_msgs/msg/Bool", typestore=store)
        for index, (record_ns, header_ns) in enumerate(stamps):
            stamp = types["builtin_interfaces/msg/Time"](sec=header_ns // SECOND, nanosec=header_ns % SECOND)
            zero = types["geometry_msgs/msg/Vector3"](x=0.0, y=0.0, z=0.0)
            message = types["sensor_msgs/msg/Imu"](
                header=types["std_msgs/msg/Header"](seq=index, stamp=stamp, frame_id="imu"),
                orientation=types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=0.0, w=1.0),
                orientation_covariance=COVARIANCE,
                angular_velocity=zero,
                angular_velocity_covariance=COVARIANCE,
                linear_acceleration=zero,
                linear_acceleration_covariance=COVARIANCE,
            )
            writer.write(imu, record_ns, store.serialize_ros1(message, "sensor_msgs/msg/Imu"))
            flag = types["std_msgs/msg/Bool"](data=False)
            writer.write(stop, record_ns, store.serialize_ros1(flag, "std_msgs/msg/Bool"))
    return path


COVARIANCE = np.zeros(9)


def reports(path: Path) -> dict[str, TopicReport]:
    return {topic.name: topic for topic in inspect_recording(path).topics}


def test_rate_and_gap_are_of_the_headers_and_the_clocks_are_compared(tmp_path: Path) -> None:
    header = [10.0, 10.1, 10.2, 10.6, 10.7]
    stamps = [(int((h + 90.25) * SECOND) + index * 1000, int(h * SECOND)) for index, h in enumerate(header)]
    imu = reports(write_imu_bag(tmp_path / "a.bag", stamps))["/imu"]
    assert (imu.count, imu.time, imu.backwards, imu.zero_stamps) == (5, "header", 0, 0)
    assert imu.rate_hz == pytest.approx(4 / 0.7)
    assert imu.gap_max_s == pytest.approx(0.4)
    assert imu.clock_offset_s == pytest.approx(-90.250002)


def test_backward_and_empty_stamps_are_counted_and_the_gap_is_in_order_of_time(tmp_path: Path) -> None:
    header = [10.0, 10.2, 10.1, 0.0, 10.3]
    stamps = [(int((20.0 + 0.5 * index) * SECOND), int(h * SECOND)) for index, h in enumerate(header)]
    imu = reports(write_imu_bag(tmp_path / "a.bag", stamps))["/imu"]
    assert (imu.time, imu.backwards, imu.zero_stamps) == ("header", 1, 1)
    assert imu.gap_max_s == pytest.approx(0.1)


def test_without_header_stamps_the_time_of_record_counts(tmp_path: Path) -> None:
    stamps = [(int((20.0 + 0.5 * index) * SECOND), 0) for index in range(4)]
    found = reports(write_imu_bag(tmp_path / "a.bag", stamps))
    for name in ("/imu", "/e_stop"):
        assert (found[name].time, found[name].clock_offset_s) == ("record", None)
        assert found[name].rate_hz == pytest.approx(2.0)
    assert (found["/imu"].zero_stamps, found["/e_stop"].zero_stamps) == (4, 0)


def test_a_single_message_has_neither_rate_nor_gap(tmp_path: Path) -> None:
    imu = reports(write_imu_bag(tmp_path / "a.bag", [(SECOND, SECOND)]))["/imu"]
    assert (imu.rate_hz, imu.gap_max_s, imu.clock_offset_s) == (None, None, 0.0)


def test_every_byte_is_announced_once(tmp_path: Path) -> None:
    sizes: list[int] = []
    inspect_recording(write_imu_bag(tmp_path / "a.bag", [(SECOND, SECOND)] * 3), on_read=sizes.append)
    assert len(sizes) == 6
    assert sizes.count(1) == 3


def test_the_json_has_the_promised_keys_and_only_plain_values(tmp_path: Path) -> None:
    path = write_imu_bag(tmp_path / "a.bag", [(SECOND, SECOND), (2 * SECOND, 2 * SECOND)])
    told = json.loads(json.dumps(inspect_recording(path).to_json(), allow_nan=False))
    assert list(told) == ["path", "format", "start_ns", "end_ns", "messages", "topics", "topic_map", "faults", "notes"]
    assert (told["path"], told["format"], told["messages"]) == (str(path), "ros1", 4)
    assert (told["start_ns"], told["end_ns"]) == (SECOND, 2 * SECOND)
    assert {"name", "type", "count", "rate_hz", "gap_max_s"} <= set(told["topics"][0])
    assert told["topic_map"]["imu"] == "/imu"
    assert told["topic_map"]["intervention"] == "/e_stop"
    assert told["topic_map"]["camera"] is None
    assert told["topic_map"]["not_used"] == []


def test_a_candidate_of_another_type_is_refused(tmp_path: Path) -> None:
    path = write_imu_bag(tmp_path / "a.bag", [(SECOND, SECOND)])
    with pytest.raises(DatasetsError, match="/e_stop is std_msgs/msg/Bool"):
        inspect_recording(path, RobotConfig(topics=TopicCandidates(imu=["/e_stop"])))


def test_the_robot_file_of_an_inspection_gives_the_same_map_again(tmp_path: Path) -> None:
    path = write_imu_bag(tmp_path / "a.bag", [(SECOND, SECOND)])
    base = RobotConfig(name="box", topics=TopicCandidates(odometry=["/odom"], battery=["none"]))
    found = inspect_recording(path, base)
    robot = robot_from(base, found)
    assert robot.topics == TopicCandidates(imu=["/imu"], intervention=["/e_stop"], odometry=["/odom"], battery=["none"])
    assert (robot.name, base.topics.imu) == ("box", [])
    assert inspect_recording(path, robot).topic_map.streams == found.topic_map.streams


def test_the_husky_recording_has_its_documented_counts(recordings: Path) -> None:
    found = inspect_recording(recordings / "bags/husky_outdoor/test1.bag")
    assert (found.messages, found.format) == (16_806, "ros1")
    assert (found.end_ns - found.start_ns) * 1e-9 == pytest.approx(395.3, abs=0.05)
    topics = {topic.name: topic for topic in found.topics}
    counts = {name: topic.count for name, topic in topics.items()}
    assert counts == {"/fix": 989, "/husky_velocity_controller/odom": 3952, "/imu/data": 11_865}
    rates = {name: round(topic.rate_hz or 0.0, 1) for name, topic in topics.items()}
    assert rates == {"/fix": 2.5, "/husky_velocity_controller/odom": 10.0, "/imu/data": 30.0}
    assert topics["/husky_velocity_controller/odom"].gap_max_s == pytest.approx(0.21, abs=0.005)
    assert topics["/imu/data"].clock_offset_s == pytest.approx(-0.025, abs=0.001)
    assert (found.topic_map.topic_of("odometry"), found.topic_map.topic_of("imu")) == (
        "/husky_velocity_controller/odom",
        "/imu/data",
    )
    assert [topic.name for topic in found.topic_map.not_used] == ["/fix"]


def test_an_imu_whose_stamps_run_backwards_is_told_from_the_good_one(recordings: Path) -> None:
    found = reports(recordings / "bags/ground_vehicle_xsens/test1_2014.bag")
    assert found["/my_odometry2imu/imu_data"].backwards == 31
    assert found["/xsens/imu_data"].backwards == 0
    assert found["/stereo_odometer/odometry"].clock_offset_s == pytest.approx(-0.15, abs=0.01)


@pytest.mark.parametrize(
    ("name", "streams"),
    [
        ("husky_sim_joint_odom/le_bag", {"odometry", "joints", "command"}),
        ("amber_soccer_goal/soccer_goal_12.mcap", {"camera"}),
        ("ouster_raw/512x10_raw.bag", set()),
        ("rosbag_js/no-messages.bag", set()),
        ("plotjuggler/rosbag2_test", {"imu", "battery"}),
        ("evo/nav2_turtlebot.mcap", {"odometry"}),
        ("jackal_velodyne_scan/test_2026-02-17-16-26-34.bag", {"lidar", "command"}),
    ],
)
def test_what_other_real_recordings_can_feed(recordings: Path, name: str, streams: set[str]) -> None:
    found = inspect_recording(recordings / "bags" / name)
    assert set(found.topic_map.streams) == streams
    listed = {(topic.name, topic.type) for topic in found.topics}
    mapped = {(topic.name, topic.type) for topic in found.topic_map.not_used}
    assert {name for name, _ in listed - mapped} == set(found.topic_map.topics())
