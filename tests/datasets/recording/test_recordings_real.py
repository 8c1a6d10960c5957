"""The real recordings: what each contains was counted when they were collected."""

import shutil
from collections import Counter
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.decode import messages as m
from navtool.datasets.decode.table import MESSAGES
from navtool.datasets.recording import RawMessage, Recording, RecordingFormat, open_recording

pytestmark = pytest.mark.recordings

COUNTS = {
    "bags/husky_outdoor/test1.bag": 16_806,
    "bags/ground_vehicle_xsens/test1_2014.bag": 29_274,
    "bags/jackal_velodyne_scan/test_2026-02-17-16-26-34.bag": 6_139,
    "bags/kleinkram_imu/test_small.bag": 17_029,
    "bags/swri_pointcloud2/PointCloud2.bag": 1,
    "bags/plotjuggler/tilt_laser.bag": 4_093,
    "bags/plotjuggler/rosbag2_test": 4_695,
    "bags/husky_sim_joint_odom/le_bag": 3_577,
    "bags/panda_joint_states/joint_states.bag": 988,
    "bags/evo/nav2_turtlebot.mcap": 8_197,
    "bags/evo/tf_example.bag": 518,
    "bags/evo/tf_example": 518,
    "bags/amber_soccer_goal": 2,
    "bags/rerun_all_sensor_msgs/rosbag2_2025_09_10-13_03_56_0.mcap": 194,
    "bags/ouster_raw/512x10_raw.bag": 43,
    "bags/grand_tour_calib/tf_static_metadata_new_0.bag": 12,
    "bags/rosbag_js/example-bz2.bag": 8_647,
    "bags/rosbag_js/no-messages.bag": 0,
}
TOPICS = {
    "bags/husky_outdoor/test1.bag": {
        "/imu/data": ("sensor_msgs/msg/Imu", 11_865),
        "/husky_velocity_controller/odom": ("nav_msgs/msg/Odometry", 3_952),
        "/fix": ("sensor_msgs/msg/NavSatFix", 989),
    },
    "bags/ground_vehicle_xsens/test1_2014.bag": {
        "/xsens/imu_data": ("sensor_msgs/msg/Imu", 13_334),
        "/wheel_odometry": ("nav_msgs/msg/Odometry", 1_294),
        "/stereo_odometer/odometry": ("nav_msgs/msg/Odometry", 1_313),
        "/my_odometry2imu/imu_data": ("sensor_msgs/msg/Imu", 13_333),
    },
    "bags/jackal_velodyne_scan/test_2026-02-17-16-26-34.bag": {
        "/vrpn_client_node/jackal/pose": ("geometry_msgs/msg/PoseStamped", 5_206),
        "/scan": ("sensor_msgs/msg/LaserScan", 431),
        "/cmd_vel": ("geometry_msgs/msg/Twist", 251),
        "/controller_output_linear": ("geometry_msgs/msg/Twist", 251),
    },
    "bags/kleinkram_imu/test_small.bag": {"/sensors/imu": ("sensor_msgs/msg/Imu", 17_029)},
    "bags/swri_pointcloud2/PointCloud2.bag": {"/pointcloud2": ("sensor_msgs/msg/PointCloud2", 1)},
    "bags/plotjuggler/tilt_laser.bag": {
        "/scan": ("sensor_msgs/msg/LaserScan", 178),
        "/imu_data": ("sensor_msgs/msg/Imu", 356),
        "/position_gps": ("sensor_msgs/msg/NavSatFix", 356),
        "/tf": ("tf/msg/tfMessage", 711),
        "/velocity": ("geometry_msgs/msg/TwistStamped", 712),
    },
    "bags/plotjuggler/rosbag2_test": {
        "/imu": ("sensor_msgs/msg/Imu", 1_565),
        "/battery": ("sensor_msgs/msg/BatteryState", 1_565),
        "/pose": ("geometry_msgs/msg/PoseStamped", 1_565),
    },
    "bags/husky_sim_joint_odom/le_bag": {
        "/husky_velocity_controller/odom": ("nav_msgs/msg/Odometry", 386),
        "/joint_states": ("sensor_msgs/msg/JointState", 386),
        "/tf": ("tf2_msgs/msg/TFMessage", 385),
        "/tf_static": ("tf2_msgs/msg/TFMessage", 1),
        "/husky_velocity_controller/cmd_vel_unstamped": ("geometry_msgs/msg/Twist", 87),
    },
    "bags/panda_joint_states/joint_states.bag": {"/joint_states": ("sensor_msgs/msg/JointState", 988)},
    "bags/evo/nav2_turtlebot.mcap": {
        "/odom": ("nav_msgs/msg/Odometry", 2_639),
        "/tf": ("tf2_msgs/msg/TFMessage", 5_422),
        "/tf_static": ("tf2_msgs/msg/TFMessage", 1),
        "/amcl_pose": ("geometry_msgs/msg/PoseWithCovarianceStamped", 135),
    },
    "bags/evo/tf_example.bag": {
        "/tf": ("tf2_msgs/msg/TFMessage", 517),
        "/tf_static": ("tf2_msgs/msg/TFMessage", 1),
    },
    "bags/amber_soccer_goal": {"/camera/image_raw": ("sensor_msgs/msg/Image", 2)},
    "bags/ouster_raw/512x10_raw.bag": {
        "/os_node0/lidar_packets": ("ouster_ros/msg/PacketMsg", 32),
        "/os_node0/imu_packets": ("ouster_ros/msg/PacketMsg", 10),
        "/os_node0/metadata": ("std_msgs/msg/String", 1),
    },
}


@pytest.fixture(params=sorted(COUNTS))
def opened(request: pytest.FixtureRequest, recordings: Path) -> Iterator[tuple[str, Recording]]:
    """The name and the recording of each in turn."""
    with open_recording(recordings / request.param) as recording:
        yield request.param, recording


def everything(recording: Recording) -> Iterator[RawMessage]:
    return recording.messages({topic.name for topic in recording.topics})


def samples(recording: Recording, topic: str, every: int = 1) -> list[Any]:
    return [recording.decode(raw) for raw in islice(recording.messages([topic]), None, None, every)]


def test_the_counts_are_those_that_were_measured(opened: tuple[str, Recording]) -> None:
    name, recording = opened
    assert recording.message_count == sum(topic.count for topic in recording.topics) == COUNTS[name]
    found = {topic.name: (topic.type, topic.count) for topic in recording.topics}
    expected = TOPICS.get(name, {})
    assert {topic: found.get(topic) for topic in expected} == expected


@pytest.mark.parametrize("every", [pytest.param(1, marks=pytest.mark.slow), 50])
def test_messages_come_in_time_and_those_of_a_known_type_decode(opened: tuple[str, Recording], every: int) -> None:
    name, recording = opened
    times: list[int] = []
    seen: Counter[str] = Counter()
    for raw in everything(recording):
        times.append(raw.record_ns)
        if raw.type in MESSAGES and seen[raw.topic] % every == 0:
            assert recording.decode(raw).stamp_ns == recording.header_stamp_ns(raw)
        seen[raw.topic] += 1
    assert len(times) == COUNTS[name]
    assert times == sorted(times)
    if times:
        assert (recording.start_ns, recording.end_ns) == (times[0], times[-1])


def test_packets_are_read_though_the_recording_defines_them_not(recordings: Path) -> None:
    (folder,) = {x.parent for x in (recordings / "lidar/nebula_vlp16").rglob("metadata.yaml")}
    with open_recording(folder) as recording:
        assert [(x.name, x.type, x.count) for x in recording.topics] == [
            ("/velodyne_packets", "velodyne_msgs/msg/VelodyneScan", 4)
        ]
        raw = next(everything(recording))
        cloud = recording.decode(raw)
        assert isinstance(cloud, m.PointCloud)
        assert cloud.stamp_ns == recording.header_stamp_ns(raw) == 1_673_400_471_737_763_166
        assert len(cloud.xyz) == 14_885


def test_the_two_forms_of_one_recording_give_the_same_transforms(recordings: Path) -> None:
    found = []
    for name in ("tf_example.bag", "tf_example"):
        with open_recording(recordings / "bags/evo" / name) as recording:
            found.append([(raw.topic, raw.record_ns, recording.decode(raw)) for raw in everything(recording)])
    for (topic, record_ns, one), (other_topic, other_ns, other) in zip(*found, strict=True):
        assert (topic, record_ns) == (other_topic, other_ns)
        assert isinstance(one, m.TransformsSample)
        assert isinstance(other, m.TransformsSample)
        for a, b in zip(one.transforms, other.transforms, strict=True):
            assert (a.parent, a.child, a.stamp_ns) == (b.parent, b.child, b.stamp_ns)
            np.testing.assert_array_equal(a.matrix, b.matrix)


def test_nothing_is_written_into_the_folders_of_the_recordings(recordings: Path, tmp_path: Path) -> None:
    originals = sorted((str(x), x.stat().st_mtime_ns) for x in (recordings / "bags").rglob("*"))
    for name in COUNTS:
        with open_recording(recordings / name) as recording:
            next(everything(recording), None)
    assert sorted((str(x), x.stat().st_mtime_ns) for x in (recordings / "bags").rglob("*")) == originals
    # The same where writing would be allowed.
    copy = tmp_path / "rosbag2_test"
    copy.mkdir()
    for file in (recordings / "bags/plotjuggler/rosbag2_test").iterdir():
        shutil.copyfile(file, copy / file.name)
    before = sorted(x.name for x in copy.iterdir())
    with open_recording(copy) as recording:
        assert len(list(everything(recording))) == 4_695
        assert sorted(x.name for x in copy.iterdir()) == before
    assert sorted(x.name for x in copy.iterdir()) == before


def test_a_real_photo_out_of_a_part_of_a_recording_whose_messages_are_compressed(recordings: Path) -> None:
    with open_recording(recordings / "bags/amber_soccer_goal/soccer_goal_12.mcap") as recording:
        assert recording.format is RecordingFormat.mcap
        frame, _ = samples(recording, "/camera/image_raw")
        assert frame.rgb.shape == (480, 640, 3)
        assert frame.encoding == "rgb8"
        # A photo, not noise: neighbouring pixels resemble each other.
        assert np.abs(np.diff(frame.rgb.astype(int), axis=1)).mean() < 20 < frame.rgb.std()


def test_a_padded_cloud_with_intensity_and_rings(recordings: Path) -> None:
    with open_recording(recordings / "bags/swri_pointcloud2/PointCloud2.bag") as recording:
        (cloud,) = samples(recording, "/pointcloud2")
        assert cloud.frame_id == "near_field"
        assert len(cloud.xyz) + cloud.dropped_nonfinite == 124_914
        assert 372 < cloud.xyz[:, 0].min() < cloud.xyz[:, 0].max() < 534
        assert -1337 < cloud.xyz[:, 1].min() < cloud.xyz[:, 1].max() < -1120
        assert (float(cloud.intensity.min()), float(cloud.intensity.max())) == (2.75, 255.0)
        assert len(np.unique(cloud.ring)) == 64
        assert cloud.time_s is None


def test_values_that_the_collectors_noted(recordings: Path) -> None:
    with open_recording(recordings / "bags/husky_outdoor/test1.bag") as recording:
        gravity = np.mean([x.linear_acceleration for x in samples(recording, "/imu/data", 20)], axis=0)
        assert gravity[1] == pytest.approx(9.6, abs=0.2)
        path = np.array([x.position for x in samples(recording, "/husky_velocity_controller/odom")])
        assert np.linalg.norm(np.diff(path, axis=0), axis=1).sum() == pytest.approx(359, abs=1)
    with open_recording(recordings / "bags/husky_sim_joint_odom/le_bag") as recording:
        joints = samples(recording, "/joint_states")
        assert {len(x.names) for x in joints} == {14}
        assert all(np.isnan(x.effort).all() and np.isfinite(x.position).all() for x in joints)
    with open_recording(recordings / "bags/panda_joint_states/joint_states.bag") as recording:
        assert all(len(x.names) == 9 and np.isfinite(x.effort).all() for x in samples(recording, "/joint_states"))
    with open_recording(recordings / "bags/ground_vehicle_xsens/test1_2014.bag") as recording:
        assert {x.child_frame_id for x in samples(recording, "/wheel_odometry", 20)} == {""}
        assert min(np.abs(x.position).max() for x in samples(recording, "/stereo_odometer/odometry", 20)) > 5e6
    with open_recording(recordings / "bags/jackal_velodyne_scan/test_2026-02-17-16-26-34.bag") as recording:
        scans = samples(recording, "/scan")
        assert {x.frame_id for x in scans} == {"velodyne"}
        assert 0 < min(len(x.xyz) for x in scans) <= max(len(x.xyz) for x in scans) <= 897
        assert all(not x.xyz[:, 2].any() and x.dropped_nonfinite == 0 for x in scans)
    with open_recording(recordings / "bags/plotjuggler/tilt_laser.bag") as recording:
        scans = samples(recording, "/scan", 20)
        # Beams without a return are recorded at 1 mm, below the scanner's nearest range.
        assert min(float(np.linalg.norm(x.xyz, axis=1).min()) for x in scans) > 0.023
        assert max(len(x.xyz) for x in scans) < 1078
        assert all(0 <= x.time_s.min() <= x.time_s.max() < 0.02 for x in scans)


def test_a_recording_whose_file_is_absent_names_it(recordings: Path) -> None:
    with pytest.raises(DatasetsError, match=r"1 of the 1 files it lists are missing: robot_bag_0\.db3"):
        open_recording(recordings / "proprio/unitree_go2/test_1")


def test_pictures_and_tables_are_no_recordings(recordings: Path) -> None:
    for name in ("SOURCES.md", "photos/utadl_forest/forest1.jpg", "proprio/unitree_go2/test_1/state_history.csv"):
        with pytest.raises(DatasetsError, match="not a recording"):
            open_recording(recordings / name)
