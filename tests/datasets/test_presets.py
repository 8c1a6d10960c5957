"""Every preset reads a recording with the topics, types and traps of the robots that it is named after."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from navtool.cli.robots import ingest_job
from navtool.datasets.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig, Merge
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.reader import NavDataset
from navtool.datasets.recording import Topic
from navtool.datasets.robot import JoyCommand, RobotConfig, TopicCandidates
from navtool.datasets.topic_map import resolve_topic_map

PRESETS = sorted(path.stem for path in (Path(__file__).parents[2] / "configs" / "robot").glob("*.yaml"))
DRIVE = {
    "image": "/camera/image_raw/compressed",
    "camera_info": "/camera/camera_info",
    "lidar": "/points",
    "odometry": "/odom",
    "imu": "/imu/data",
    "joints": "/joint_states",
    "battery": "/battery_state",
    "command": "/cmd_vel",
    "intervention": "/operator/intervention",
}
"""The streams' topics in the drives of the tests."""
LACKING: dict[str, set[str]] = {
    "m2dgr": {"odometry", "joints", "battery", "command", "camera_info"},
    "tartandrive1": {"lidar", "camera_info", "joints", "battery"},
    "tartandrive2": {"camera_info", "joints", "battery"},
    "scand_jackal": {"imu", "camera_info", "joints", "battery"},
    "scand_spot": {"imu", "camera_info", "joints", "battery"},
    "fusionportable_v2": {"battery", "command"},
    "paad": {"camera_info"},
}
"""What the recordings of a preset do not have."""
ROS2 = ("unitree_ros2", "spot_ros2", "clearpath_ros2", "turtlebot4", "go2")


def _robot(name: str) -> RobotConfig:
    return ingest_job(name, []).robot


def _joy(stamp: dict[str, Any]) -> dict[str, Any]:
    return {**stamp, "axes": np.array([0.5, 0.0, 0.0, 0.01, -0.5, 0.0]), "buttons": np.zeros(4, np.int32)}


def _float(_: dict[str, Any]) -> dict[str, Any]:
    return {"data": 6.5}


def _odometry(stamp: dict[str, Any]) -> dict[str, Any]:
    return {**stamp, "child_frame_id": "base", "twist": {"twist": {"linear": {"x": 0.7}, "angular": {"z": -0.2}}}}


def _stamped_twist(stamp: dict[str, Any]) -> dict[str, Any]:
    return {**stamp, "twist": {"linear": {"x": 0.7}, "angular": {"z": -0.2}}}


def _mosaic(stamp: dict[str, Any]) -> dict[str, Any]:
    pixels = np.zeros((96, 128), np.uint8)
    pixels[0::2, 0::2] = 200  # the red ones of rggb
    return {**stamp, "width": 128, "height": 96, "step": 128, "encoding": "bayer_rggb8", "data": pixels.ravel()}


def _jpeg_called_rgb8(stamp: dict[str, Any]) -> dict[str, Any]:
    red = np.zeros((96, 128, 3), np.uint8)
    red[..., 2] = 200
    jpeg = cv2.imencode(".jpg", red)[1].ravel()
    return {**stamp, "width": 128, "height": 96, "step": 384, "encoding": "rgb8", "data": jpeg}


def _batteries(stamp: dict[str, Any]) -> dict[str, Any]:
    one = {**stamp, "current": -2.5, "voltage": 57.0, "charge_percentage": 80.0}
    return {"battery_states": [one, one | {"current": -1.5}]}


def _husky(stamp: dict[str, Any]) -> dict[str, Any]:
    return {**stamp, "left_driver_current": 1.5, "right_driver_current": 1.0, "mcu_and_user_port_current": 1.5}


def _jackal(stamp: dict[str, Any]) -> dict[str, Any]:
    return {**stamp, "total_current": 4.0}


def _anymal(stamp: dict[str, Any]) -> dict[str, Any]:
    values = {key: np.arange(12.0) for key in ("position", "velocity", "effort")}
    return {**stamp, "joints": {**stamp, "name": [f"joint_{n}" for n in range(12)], **values}}


def _low_state(_: dict[str, Any]) -> dict[str, Any]:
    imu = {"quaternion": [1, 0, 0, 0], "gyroscope": [0, 0, 0.5], "accelerometer": [0, 0, 9.81]}
    motors = [{"q": n, "dq": 2 * n, "tau_est": 3 * n} for n in range(20)]
    return {"imu_state": imu, "motor_state": motors, "bms_state": {"current": -4000, "soc": 80}}


def _sport(stamp: dict[str, Any]) -> dict[str, Any]:
    time = stamp["header"]["stamp"]
    along = (time["sec"] - 1_700_000_000) + time["nanosec"] * 1e-9
    return {"stamp": time, "position": [0.7 * along, 0, 0.3], "imu_state": {"quaternion": [1, 0, 0, 0]}}


def _scan(stamp: dict[str, Any]) -> dict[str, Any]:
    limits = {"angle_min": -2.0, "angle_increment": 0.005, "range_min": 0.1, "range_max": 20.0}
    return {**stamp, **limits, "ranges": np.linspace(3.0, 6.0, 800)}


OTHER_TYPES: dict[tuple[str, str], tuple[str, Callable[[dict[str, Any]], dict[str, Any]]]] = {
    ("rellis3d", "battery"): ("std_msgs/msg/Float64", _float),
    ("rellis3d", "image"): ("sensor_msgs/msg/Image", _mosaic),
    ("turtlebot4", "lidar"): ("sensor_msgs/msg/LaserScan", _scan),
    ("paad", "lidar"): ("sensor_msgs/msg/LaserScan", _scan),
    ("spot_ros1", "image"): ("sensor_msgs/msg/Image", _jpeg_called_rgb8),
    ("spot_ros1", "battery"): ("spot_msgs/msg/BatteryStateArray", _batteries),
    ("spot_ros2", "battery"): ("spot_msgs/msg/BatteryStateArray", _batteries),
    ("husky", "battery"): ("husky_msgs/msg/HuskyStatus", _husky),
    ("jackal", "battery"): ("jackal_msgs/msg/Status", _jackal),
    ("anymal_grandtour", "joints"): ("anymal_msgs/msg/AnymalState", _anymal),
    ("unitree_ros2", "imu"): ("unitree_go/msg/LowState", _low_state),
    ("unitree_ros2", "joints"): ("unitree_go/msg/LowState", _low_state),
    ("unitree_ros2", "odometry"): ("unitree_go/msg/SportModeState", _sport),
    ("musohu", "command"): ("nav_msgs/msg/Odometry", _odometry),
    ("scand_jackal", "command"): ("sensor_msgs/msg/Joy", _joy),
    ("scand_spot", "command"): ("sensor_msgs/msg/Joy", _joy),
    ("tartandrive1", "command"): ("geometry_msgs/msg/TwistStamped", _stamped_twist),
    ("anymal_grandtour", "command"): ("geometry_msgs/msg/TwistStamped", _stamped_twist),
}
"""What the streams of a preset come in where it is not the usual type."""


def _recorded(name: str, robot: RobotConfig, entries: list[Any], *, ros1: bool) -> tuple[list[Any], dict[str, str]]:
    """A drive as the preset's robot records it: its topics, types and base frame; and the topic of each stream."""
    topics: dict[str, str] = {}
    for stream, usual in DRIVE.items():
        wanted = getattr(robot.topics, stream)
        if wanted == ["none"] or stream in LACKING.get(name, set()):
            continue
        first = wanted[0] if wanted else usual
        topics[stream] = first if first.startswith("/") else f"/r1/{first}"
    stream_of = {topic: stream for stream, topic in DRIVE.items()}
    out = []
    for topic, usual_kind, record_ns, usual_fields in entries:
        kind, fields = usual_kind, usual_fields
        stream = stream_of.get(topic, "")
        if not stream:
            moved = [t | {"header": t["header"] | {"frame_id": robot.base_frame}} for t in fields["transforms"]]
            out.append((topic, kind, record_ns, {"transforms": moved}))
        elif stream in topics:
            if stream == "joints" and topics.get("imu") == topics["joints"]:
                continue  # one message feeds both
            if (name, stream) in OTHER_TYPES:
                kind, make = OTHER_TYPES[name, stream]
                header = {"stamp": {"sec": record_ns // 10**9, "nanosec": record_ns % 10**9}, "frame_id": ""}
                header["frame_id"] = {"image": "camera_optical", "lidar": "lidar"}.get(stream, "")
                fields = make({"header": header | ({"seq": 0} if ros1 else {})})
            if stream == "joints" and robot.joint_names:
                names = list(reversed(robot.joint_names))
                values = {key: np.arange(len(names), dtype=float) for key in ("position", "velocity", "effort")}
                fields = fields | {"name": names} | values
            out.append((topics[stream], kind, record_ns, fields))
    return out, topics


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_reads_the_recordings_of_its_robot(
    name: str, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    robot, ros1 = _robot(name), name not in ROS2
    entries, topics = _recorded(name, robot, drive_entries(2.0, ros1=ros1), ros1=ros1)
    report = ingest([write_recording("ros1" if ros1 else "mcap", entries)], tmp_path / "out", robot, IngestConfig())
    assert report.quarantined == []
    episode = report.episodes[0]
    assert episode.topics == topics
    dataset = NavDataset(tmp_path / "out")
    assert dataset.column("valid.image").all()
    if "lidar" in topics:
        assert dataset.calibration(0).base_lidar is not None
        assert dataset.column("valid.lidar")[2:].all()
        assert dataset.column("observation.lidar.count")[2:].min() > 50
    if "battery" in topics:
        sign = 6.5 / 4.0 if name == "rellis3d" else 1.0
        current = dataset.column("observation.proprioception")[5, -1]
        assert current == pytest.approx(4.0 * sign), "a discharging current is positive"
    if name == "unitree_ros2":
        np.testing.assert_allclose(dataset.column("observation.state")[3:-3, 0], 0.7, atol=1e-3)
        np.testing.assert_allclose(dataset.column("observation.imu")[5], [0, 0, 9.81, 0, 0, 0.5], atol=1e-5)
        joints = dataset.features["observation.proprioception"].names
        assert joints is not None
        assert joints[3] == "position.FL_hip_joint"
        assert dataset.column("observation.proprioception")[5, 3] == pytest.approx(3.0)
    if name == "anymal_grandtour":
        assert dataset.column("observation.proprioception")[5, 11] == pytest.approx(11.0)
    if robot.joint_names:
        position = dataset.column("observation.proprioception")[5, : len(robot.joint_names)]
        assert position.tolist() == list(range(len(robot.joint_names)))[::-1]
    if "command" in topics:
        wanted = {"scand_jackal": (0.8, -0.7854), "scand_spot": (0.8, -0.7854)}.get(name)
        usual = (0.7, -0.2) if (name, "command") in OTHER_TYPES else (1.0, 0.0)
        np.testing.assert_allclose(dataset.column("action")[8], wanted or usual, atol=1e-4)
        assert dataset.column("valid.action")[8]
    if (name, "image") in OTHER_TYPES:
        red, green, blue = dataset.image(3).reshape(-1, 3).mean(axis=0)
        assert red > 2 * max(green, blue)


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
    scanner, robot = Topic(topic, "sensor_msgs/msg/LaserScan", 9), _robot(name)
    lidar = next(iter(robot.topics.lidar), "/velodyne_points")
    cloud = Topic(lidar if lidar.startswith("/") else f"/a200/{lidar}", "sensor_msgs/msg/PointCloud2", 9)
    assert resolve_topic_map(robot.topics, [scanner]).lidar == topic
    assert resolve_topic_map(robot.topics, [scanner, cloud]).lidar == cloud.name


def test_the_bags_of_a_mission_become_one_episode(
    recording_writer: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    missions = []
    for number in range(2):
        folder = tmp_path / f"mission-{number}"
        folder.mkdir()
        missions.append(folder)
        for part, streams in enumerate((("tf",), ("image",), ("lidar", "imu"), ("odometry", "command", "joints"))):
            kind = "mcap" if part == 2 else "ros1"
            entries = drive_entries(2.0, seed=number, streams=streams, ros1=kind == "ros1")
            recording_writer(folder, kind, entries, f"part_{part}")
    apart = ingest([tmp_path], tmp_path / "apart", RobotConfig(), IngestConfig())
    assert len(apart.episodes) + len(apart.quarantined) == 8
    out = tmp_path / "out"
    report = ingest(missions, out, RobotConfig(), IngestConfig(merge=Merge.folder))
    assert [episode.source.rpartition("/")[2] for episode in report.episodes] == ["mission-0", "mission-1"]
    dataset = NavDataset(out)
    for stream in ("image", "lidar", "state", "imu", "joints"):
        assert dataset.column(f"valid.{stream}")[2:18].all(), stream
    assert dataset.calibration(1).base_lidar is not None
    again = ingest([tmp_path / "mission-0"], out, RobotConfig(), IngestConfig(merge=Merge.folder))
    assert len(again.skipped) == 1


def test_a_joystick_without_meaning_is_told(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    stamp = {"sec": 1_700_000_000, "nanosec": 0}
    joy = ("/joy", "sensor_msgs/msg/Joy", 1_700_000_000_000_000_000, _joy({"header": {"stamp": stamp}}))
    path = write_recording("mcap", [joy, *drive_entries(streams=("image", "odometry"))])
    topics = TopicCandidates(command=["/joy"])
    report = ingest([path], tmp_path / "out", RobotConfig(topics=topics), IngestConfig())
    assert report.dropped["command: cannot be decoded"] == 1
    assert any("a joystick's axes have no meaning" in note for note in report.episodes[0].notes)
    short = RobotConfig(topics=topics, joy=JoyCommand(forward_axis=9, forward_mps=1.0, turn_axis=0, turn_radps=1.0))
    report = ingest([path], tmp_path / "short", short, IngestConfig())
    assert report.dropped["command: cannot be decoded"] == 1
    with pytest.raises(DatasetsError, match="dead_zone"):
        JoyCommand(forward_axis=0, forward_mps=1.0, turn_axis=1, turn_radps=1.0, dead_zone=1.5)
