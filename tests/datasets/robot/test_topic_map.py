"""The topic map: proposals on published recordings' names, candidates in order, and nothing dropped in silence."""

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.table import proposed_types
from navtool.datasets.recording import Topic
from navtool.datasets.robot.config import RobotConfig, TopicCandidates
from navtool.datasets.robot.sensor_config import FurtherCamera, FurtherLidar
from navtool.datasets.robot.topic_map import propose_topic_map, resolve_topic_map

TYPES = {
    "Image": "sensor_msgs/msg/Image",
    "Jpeg": "sensor_msgs/msg/CompressedImage",
    "Info": "sensor_msgs/msg/CameraInfo",
    "Cloud": "sensor_msgs/msg/PointCloud2",
    "Odometry": "nav_msgs/msg/Odometry",
    "Imu": "sensor_msgs/msg/Imu",
    "Joints": "sensor_msgs/msg/JointState",
    "Battery": "sensor_msgs/msg/BatteryState",
    "Twist": "geometry_msgs/msg/Twist",
    "TwistStamped": "geometry_msgs/msg/TwistStamped",
    "Bool": "std_msgs/msg/Bool",
    "Tf": "tf2_msgs/msg/TFMessage",
    "Scan": "sensor_msgs/msg/LaserScan",
    "Echoes": "sensor_msgs/msg/MultiEchoLaserScan",
    "OldCloud": "sensor_msgs/msg/PointCloud",
    "Fix": "sensor_msgs/msg/NavSatFix",
    "Packets": "velodyne_msgs/msg/VelodyneScan",
    "Livox": "livox_ros_driver2/msg/CustomMsg",
    "Joy": "sensor_msgs/msg/Joy",
}


def listed(text: str) -> list[Topic]:
    """``Type /name [count]`` separated by semicolons."""
    topics = []
    for entry in text.split(";"):
        kind, name, *count = entry.split()
        topics.append(Topic(name, TYPES.get(kind, kind), int(count[0]) if count else 10))
    return topics


RECORDINGS: dict[str, tuple[str, dict[str, str | None]]] = {
    "RELLIS-3D": (
        """
        Image /pylon_camera_node/image_raw; Info /pylon_camera_node/camera_info;
        Image /nerian/left/image_raw; Image /nerian/right/image_raw; Cloud /os1_cloud_node/points;
        Cloud /velodyne_points; Imu /imu/data; Imu /imu/data_raw; Imu /vectornav/IMU;
        Imu /os1_cloud_node/imu; Odometry /odometry/filtered; Odometry /warthog_velocity_controller/odom;
        Odometry /vectornav/Odom; Twist /warthog_velocity_controller/cmd_vel
        """,
        {"imu": "/imu/data", "odometry": "/odometry/filtered", "command": "/warthog_velocity_controller/cmd_vel"},
    ),
    "GrandTour": (
        """
        Jpeg /boxi/hdr/front/image_raw/compressed; Info /boxi/hdr/front/camera_info;
        Jpeg /boxi/hdr/left/image_raw/compressed; Jpeg /boxi/zed2i/left/image_raw/compressed;
        Jpeg /boxi/zed2i/depth/image_raw/compressed;
        Image /anymal/depth_camera/front_upper/depth/image_rect_raw; Cloud /boxi/hesai/points;
        Cloud /boxi/hesai/points_undistorted; Odometry /anymal/state_estimator/odometry;
        Odometry /boxi/dlio/lidar_map_odometry; Imu /anymal/imu; Imu /boxi/livox/imu;
        TwistStamped /anymal/twist_command
        """,
        {
            "camera": "/boxi/hdr/front/image_raw/compressed",
            "camera_info": "/boxi/hdr/front/camera_info",
            "lidar": "/boxi/hesai/points",
            "odometry": "/anymal/state_estimator/odometry",
            "imu": "/anymal/imu",
            "command": "/anymal/twist_command",
        },
    ),
    "TartanDrive": (
        """
        Image /multisense/left/image_rect_color; Image /multisense/left/image_rect;
        Image /multisense/right/image_rect; Image /local_rgb_map; Cloud /velodyne_1/velodyne_points;
        Cloud /superodometry/velodyne_cloud_registered; Cloud /deep_cloud; Imu /novatel/imu/data;
        Imu /multisense/imu/imu_data; Odometry /odometry/filtered_odom; TwistStamped /cmd; Joy /joy
        """,
        {
            "camera": "/multisense/left/image_rect_color",
            "camera_info": None,
            "lidar": "/velodyne_1/velodyne_points",
            "imu": "/novatel/imu/data",
            "odometry": "/odometry/filtered_odom",
            "command": "/cmd",
        },
    ),
    "Spot": (
        """
        Image /spot/camera/frontleft/image; Info /spot/camera/frontleft/camera_info;
        Image /spot/camera/back/image; Info /spot/camera/back/camera_info;
        Image /spot/depth/frontleft/image; Cloud /spot/lidar/points; Odometry /spot/odometry;
        Twist /spot/cmd_vel; Joints /spot/joint_states
        """,
        {
            "camera": "/spot/camera/frontleft/image",
            "camera_info": "/spot/camera/frontleft/camera_info",
            "lidar": "/spot/lidar/points",
            "command": "/spot/cmd_vel",
            "joints": "/spot/joint_states",
            "imu": None,
        },
    ),
    "Clearpath ROS 2": (
        """
        Odometry /a200/platform/odom; Odometry /a200/platform/odom/filtered; Imu /a200/sensors/imu_0/data;
        Imu /a200/sensors/imu_0/data_raw; Joints /a200/platform/joint_states; Twist /a200/cmd_vel;
        Twist /a200/joy_teleop/cmd_vel; Bool /a200/platform/emergency_stop;
        Battery /a200/platform/bms/state; Tf /a200/tf; Tf /a200/tf_static 1
        """,
        {
            "odometry": "/a200/platform/odom/filtered",
            "imu": "/a200/sensors/imu_0/data",
            "command": "/a200/cmd_vel",
            "intervention": "/a200/platform/emergency_stop",
            "battery": "/a200/platform/bms/state",
        },
    ),
    "BADGR": (
        """
        Image /cam_left/image_raw; Image /cam_right/image_raw; Scan /rplidar/scan; Imu /imu_um7/data;
        Imu /imu/data_raw; Odometry /odometry/filtered; Twist /cmd_vel; Bool /collision/any;
        Bool /collision/stuck
        """,
        {"camera": "/cam_left/image_raw", "command": "/cmd_vel", "intervention": None, "lidar": "/rplidar/scan"},
    ),
    "only infrared, only depth clouds": (
        """
        Image /camera_forward/infra1/image_rect_raw; Image /camera/depth/image_raw;
        Cloud /camera/depth/color/points
        """,
        {"camera": "/camera_forward/infra1/image_rect_raw", "lidar": "/camera/depth/color/points"},
    ),
    "a planar scan beside clouds": (
        "Scan /scan; Scan /front/scan; Cloud /camera/depth/color/points; Cloud /rear/points",
        {"lidar": "/rear/points"},
    ),
    "a planar scan beside a cloud that its name speaks against": (
        "Scan /lidar/scan; Cloud /camera/depth/color/points",
        {"lidar": "/camera/depth/color/points"},
    ),
    "a planar scan beside a cloud without messages": (
        "Scan /scan; Cloud /points 0; Livox /livox/lidar 0",
        {"lidar": "/scan"},
    ),
    "several planar scans": ("Scan /rear/scan; Scan /front/scan; Scan /camera/scan", {"lidar": "/front/scan"}),
    "Livox and a planar scan": ("Scan /scan; Livox /livox/lidar; Imu /livox/imu", {"lidar": "/livox/lidar"}),
    "Livox in both forms": ("Livox /livox/lidar; Cloud /livox/points", {"lidar": "/livox/points"}),
    "the older cloud is nobody's": ("OldCloud /vins_estimator/point_cloud; Scan /scan", {"lidar": "/scan"}),
    "a measured velocity is no command": ("TwistStamped /velocity; Twist /controller_output_linear", {"command": None}),
}


@pytest.mark.parametrize("name", RECORDINGS)
def test_the_proposal_on_published_topic_names(name: str) -> None:
    text, wanted = RECORDINGS[name]
    proposed = propose_topic_map(listed(text))
    assert {stream: proposed.topic_of(stream) for stream in wanted} == wanted


ANY_TOPICS = st.lists(
    st.builds(
        Topic,
        name=st.sampled_from(
            [f"/{a}{b}" for a in ("", "front/", "depth/", "ns/") for b in ("odom", "cmd_vel", "x", "e_stop")]
        ),
        type=st.sampled_from(sorted(TYPES.values())),
        count=st.integers(0, 2),
    ),
    unique_by=lambda topic: topic.name,
)


@given(topics=ANY_TOPICS, seed=st.integers(0, 99))
def test_every_topic_is_used_or_listed_with_a_reason_whatever_the_order(topics: list[Topic], seed: int) -> None:
    proposed = propose_topic_map(topics)
    unused = {topic.name for topic in proposed.not_used}
    assert unused | set(proposed.topics()) == {topic.name for topic in topics}
    assert not unused & set(proposed.topics())
    assert all(topic.reason for topic in proposed.not_used)
    by_name = {topic.name: topic for topic in topics}
    for stream, name in proposed.streams.items():
        assert by_name[name].count > 0
        assert by_name[name].type in proposed_types(stream)
    shuffled = random.Random(seed).sample(topics, len(topics))  # noqa: S311 - an order, not a secret
    assert propose_topic_map(shuffled) == proposed


def named(**topics: list[str]) -> RobotConfig:
    return RobotConfig(topics=TopicCandidates(**topics))


def reasons(text: str) -> dict[str, str]:
    return {topic.name: topic.reason for topic in propose_topic_map(listed(text)).not_used}


def test_what_is_left_over_says_why() -> None:
    given_reasons = reasons(
        "Image /front/image_raw; Jpeg /front/image_raw/compressed; Image /rear/image_raw; Info /rear/camera_info;"
        "Image /front/depth/image_raw; Scan /scan; Fix /fix; Livox /livox/lidar; Livox /livox/other; Joy /joy;"
        "Echoes /echoes; OldCloud /features;"
        "ouster_ros/msg/PacketMsg /os_node/lidar_packets;"
        "Odometry /odom; Odometry /gps/odom; Imu /imu 0; my_msgs/msg/Thing /thing; Twist /velocity;"
        "geometry_msgs/msg/PoseStamped /pose"
    )
    assert given_reasons == {
        "/fix": "satellite positions have no column in the data set",
        "/front/depth/image_raw": "a depth or derived image; the data set takes colour images",
        "/front/image_raw/compressed": "the same images as /front/image_raw in another encoding",
        "/gps/odom": "another odometry; /odom is used",
        "/imu": "no messages",
        "/joy": "joystick axes are not velocities; name it as command, with `joy`, in the robot file",
        "/echoes": "a planar scan of several echoes; record one of them as a LaserScan",
        "/features": "the old cloud type, of sensors or of features; name it as lidar in the robot file",
        "/livox/other": "another point cloud; /livox/lidar is used",
        "/pose": "poses without speeds; name it as odometry in the robot file if they are the robot's own",
        "/rear/camera_info": "calibration of a camera that is not used",
        "/rear/image_raw": "another camera; /front/image_raw is used",
        "/scan": "a planar scan; /livox/lidar is used",
        "/thing": "no decoder for my_msgs/msg/Thing",
        "/velocity": "its name does not say that it is the command; name it in the robot file if it is",
        "/os_node/lidar_packets": "raw packets of a sensor, which are not decoded; record its driver's PointCloud2",
    }


def test_a_planar_scan_is_told_whether_it_is_proposed_or_named() -> None:
    note = "lidar: /scan is a planar scan: its clouds are a line of points at the scanner's height"
    proposed = propose_topic_map(listed("Scan /scan; Scan /other_scan"))
    assert noted(proposed.notes, "topics.planar-scan") == [note]
    assert [(topic.name, topic.reason) for topic in proposed.not_used] == [
        ("/other_scan", "a planar scan; /scan is used")
    ]
    both = listed("Scan /scan; Cloud /points")
    chosen = resolve_topic_map(named(lidar=["/absent", "scan"]), both)
    assert chosen.topic_of("lidar") == "/scan"
    assert noted(chosen.notes, "topics.planar-scan") == [note]
    assert [topic.reason for topic in chosen.not_used] == ["another point cloud; /scan is used"]
    assert propose_topic_map(both).notes == ()
    left_out = resolve_topic_map(named(lidar=["none"]), listed("Scan /scan"))
    assert [topic.reason for topic in left_out.not_used] == ["not among the robot's candidates for lidar"]
    equal = propose_topic_map(listed("Scan /scan_a; Scan /scan_b"))
    told = noted(equal.notes, "topics.equal")
    assert told == ["lidar: /scan_a and /scan_b fit equally; name one in the robot file"]


@given(topics=ANY_TOPICS)
def test_planar_scans_change_nothing_where_there_is_a_cloud(topics: list[Topic]) -> None:
    without = [topic for topic in topics if topic.type != TYPES["Scan"]]
    all_of_them, others = propose_topic_map(topics), propose_topic_map(without)
    if others.topic_of("lidar") is not None:
        assert all_of_them.topic_of("lidar") == others.topic_of("lidar")
        assert all_of_them.notes == others.notes


def test_candidates_are_taken_in_order_and_never_replaced_by_a_guess() -> None:
    topics = listed("Odometry /odom; Odometry /odometry/filtered 0; Imu /imu/data; Cloud /points; Twist /cmd_vel")
    candidates = named(
        odometry=["/absent", "/odometry/filtered", "/odom"], lidar=["/velodyne_points"], command=["none"]
    )
    resolved = resolve_topic_map(candidates, topics)
    assert (
        resolved.topic_of("odometry"),
        resolved.topic_of("lidar"),
        resolved.topic_of("command"),
        resolved.topic_of("imu"),
    ) == ("/odom", None, None, "/imu/data")
    (note,) = [text for text in noted(resolved.notes, "topics.none-of-them") if text.startswith("lidar")]
    assert "/velodyne_points" in note
    assert "/points" in note
    assert {topic.name: topic.reason for topic in resolved.not_used}[
        "/cmd_vel"
    ] == "not among the robot's candidates for command"


def test_a_relative_candidate_matches_in_any_namespace_but_only_whole_parts() -> None:
    topics = listed("Odometry /a200/platform/odom; Odometry /xplatform/odom; Imu /a200/imu")
    assert resolve_topic_map(named(odometry=["platform/odom"]), topics).topic_of("odometry") == "/a200/platform/odom"
    assert resolve_topic_map(named(odometry=["/platform/odom"]), topics).topic_of("odometry") is None


def test_candidates_of_another_type_are_all_named() -> None:
    topics = listed("Imu /odom; Odometry /imu")
    with pytest.raises(DatasetsError) as caught:
        resolve_topic_map(named(odometry=["/odom"], imu=["/imu"]), topics)
    assert "/odom is sensor_msgs/msg/Imu, wanted nav_msgs/msg/Odometry" in caught.value.what
    assert "/imu is nav_msgs/msg/Odometry, wanted sensor_msgs/msg/Imu" in caught.value.what


def test_a_topic_of_several_types_feeds_no_stream_unless_one_of_them_is_empty() -> None:
    both = propose_topic_map(listed("Odometry /odom; Imu /odom; Odometry /other"))
    assert both.topic_of("odometry") == "/other"
    assert [topic.reason for topic in both.not_used] == ["carries messages of several types"] * 2
    one = propose_topic_map(listed("Odometry /odom; Imu /odom 0"))
    assert one.topic_of("odometry") == "/odom"
    assert [(topic.type, topic.reason) for topic in one.not_used] == [("sensor_msgs/msg/Imu", "no messages")]


def test_camera_info_follows_the_camera_that_the_robot_file_names() -> None:
    topics = listed(
        "Image /front/image_raw; Info /front/camera_info; Jpeg /rear/image_color/compressed; Info /rear/camera_info"
    )
    resolved = resolve_topic_map(named(camera=["/rear/image_color/compressed"]), topics)
    assert resolved.topic_of("camera_info") == "/rear/camera_info"
    lonely = propose_topic_map(listed("Image /camera/image; Info /calibration"))
    assert lonely.topic_of("camera_info") == "/calibration"
    assert noted(lonely.notes, "topics.only-calibration")


REAR_CAMERA = RobotConfig(cameras={"rear": FurtherCamera(topics=["/cam/image_raw"])})


def test_a_further_sensors_topic_is_never_taken_for_the_first_ones() -> None:
    alone = resolve_topic_map(REAR_CAMERA, listed("Image /cam/image_raw; Jpeg /cam/image_raw/compressed"))
    assert alone.streams == {"camera.rear": "/cam/image_raw"}
    assert [topic.reason for topic in alone.not_used] == ["the same images as /cam/image_raw in another encoding"]
    both = resolve_topic_map(REAR_CAMERA, listed("Image /cam/image_raw; Image /other/image_raw; Info /cam/camera_info"))
    assert both.streams == {
        "camera": "/other/image_raw",
        "camera.rear": "/cam/image_raw",
        "camera_info.rear": "/cam/camera_info",
    }
    assert list(both.streams) == ["camera", "camera.rear", "camera_info.rear"], "further ones behind the first"


def test_one_topic_cannot_be_two_cameras() -> None:
    robot = RobotConfig(
        topics=TopicCandidates(camera=["/left/image", "/cam/image_raw"], lidar=["points"]),
        cameras=REAR_CAMERA.cameras,
        lidars={"roof": FurtherLidar(topics=["/roof/points"])},
    )
    assert (
        resolve_topic_map(robot, listed("Image /left/image; Image /cam/image_raw")).topic_of("camera") == "/left/image"
    )
    with pytest.raises(DatasetsError, match=r"camera and camera.rear are both /cam/image_raw; lidar and lidar.roof"):
        resolve_topic_map(robot, listed("Image /cam/image_raw; Cloud /roof/points"))
    with pytest.raises(DatasetsError, match=r"camera.rear: /cam/image_raw is sensor_msgs/msg/PointCloud2"):
        resolve_topic_map(REAR_CAMERA, listed("Cloud /cam/image_raw"))


@pytest.mark.parametrize(
    ("topics", "further"),
    [
        (
            "Image /front/image_raw; Image /rear/image_raw; Jpeg /rear/image_raw/compressed; Image /left/image_raw",
            {"camera.left": "/left/image_raw", "camera.rear": "/rear/image_raw"},
        ),
        (
            (
                "Image /spot/camera/frontleft/image; Image /spot/camera/frontright/image; "
                "Image /spot/camera/back/image; Image /spot/depth/back/image"
            ),
            {"camera.back": "/spot/camera/back/image", "camera.frontright": "/spot/camera/frontright/image"},
        ),
        (
            "Image /zed2/left/image_rect_color; Image /zed2/left/image_raw; Image /zed2/right/image_rect_color",
            {"camera.right": "/zed2/right/image_rect_color"},
        ),
        (
            "Image /cam_0/image; Image /cam_1/image; Image /cam_2/image; Image /cam_1/debug_image",
            {"camera.camera_1": "/cam_1/image", "camera.camera_2": "/cam_2/image"},
        ),
        (
            (
                "Cloud /velodyne_points; Packets /velodyne_packets; Cloud /ouster/points; "
                "Cloud /ouster/points_filtered; Cloud /camera/depth/points; Scan /scan; Livox /livox/lidar"
            ),
            {"lidar.livox": "/livox/lidar", "lidar.velodyne": "/velodyne_points"},
        ),
        ("Scan /scan_front; Scan /scan_rear", {"lidar.rear": "/scan_rear"}),
        ("Cloud /lidar/front/points; Cloud /lidar/rear/points 0", {}),
        ("Image /camera/color/image_raw; Jpeg /camera/color/image_raw/compressed", {}),
        ("Image /image; Jpeg /compressed_image", {}),
        ("Odometry /odom", {}),
    ],
)
def test_further_sensors_are_proposed_by_what_tells_them_apart(topics: str, further: dict[str, str]) -> None:
    proposed = propose_topic_map(listed(topics))
    assert dict(proposed.further) == further
    assert not any("." in stream for stream in proposed.streams), "proposed, and not read"
    assert propose_topic_map(listed(topics)[::-1]).further == proposed.further


def test_a_name_that_is_taken_gets_a_number() -> None:
    robot = RobotConfig(cameras={"left": FurtherCamera(topics=["/somewhere/image"])})
    topics = listed("Image /front/image; Image /somewhere/image; Image /left/image")
    assert resolve_topic_map(robot, topics).further == {"camera.left_2": "/left/image"}
