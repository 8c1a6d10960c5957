"""The robot file: what is written is read back, and every fault is named with its cure."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.base.errors import DatasetsError, NavtoolError
from navtool.base.from_plain import from_plain
from navtool.base.plain import plain
from navtool.base.setting_error import SettingError
from navtool.datasets.robot.config import RobotConfig, TopicCandidates, load_robot_file, save_robot_file

FINITE = st.floats(-1.0, 1.0, allow_nan=False)
NAMES = st.text(st.characters(codec="utf-8", exclude_categories=["C", "Z"]), min_size=1, max_size=12).filter(
    lambda name: name.strip("/ ") not in {"", "none"}
)
THREE = st.lists(FINITE, min_size=3, max_size=3)
ROBOTS = st.fixed_dictionaries(
    {
        "name": NAMES,
        "topics": st.fixed_dictionaries({"camera": st.lists(NAMES, max_size=2), "command": st.just(["none"])}),
    },
    optional={
        "base_height_m": st.floats(0.0, 5.0),
        "width_m": st.floats(0.1, 5.0),
        "joint_names": st.lists(NAMES, unique=True, max_size=3),
        "battery_current_sign": st.sampled_from([-1, 0, 1]),
        "odometry_yaw_rad": st.floats(-3.0, 3.0),
        "camera": st.none()
        | st.fixed_dictionaries(
            {
                "width": st.integers(1, 4000),
                "height": st.integers(1, 4000),
                **dict.fromkeys(("fx", "fy", "cx", "cy"), st.floats(1.0, 1e4)),
                "distortion_model": st.just("plumb_bob"),
                "distortion": st.lists(FINITE, min_size=5, max_size=5),
            }
        ),
        "mounting": st.dictionaries(
            st.sampled_from(["camera", "lidar", "imu"]), st.fixed_dictionaries({"xyz_m": THREE, "rpy_rad": THREE})
        ),
    },
)


@given(content=ROBOTS)
def test_what_is_saved_is_loaded_equal(tmp_path_factory: pytest.TempPathFactory, content: dict[str, object]) -> None:
    robot = from_plain(RobotConfig, content, where="a test")
    path = tmp_path_factory.getbasetemp() / "robot.yaml"
    save_robot_file(robot, path)
    loaded = load_robot_file(path)
    assert loaded == robot
    written = plain(loaded)
    assert isinstance(written, dict)
    assert all(written[key] == value for key, value in content.items() if key != "topics")


def test_a_file_needs_only_what_differs(tmp_path: Path) -> None:
    path = tmp_path / "husky.yaml"
    path.write_text("name: husky\nwidth_m: 1\ntopics: {imu: [/imu/data]}\n")
    assert load_robot_file(path) == RobotConfig(name="husky", width_m=1.0, topics=TopicCandidates(imu=["/imu/data"]))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("naem: husky", "did you mean 'name'"),
        ("topics: {lidr: [/points]}", "topics.lidr: there is no such key (did you mean 'lidar'?)"),
        ("topics: {image: [/front]}", "topics.image: there is no such key (did you mean 'camera'?)"),
        ("mounting: {image: {xyz_m: [0, 0, 0]}}", "mounting: unknown sensors image (did you mean 'camera'?)"),
        ("width_m: wide", "width_m: wanted a number, got the text 'wide'"),
        ("width_m: true", "width_m: wanted a number, got True"),
        ("width_m: -1", "-1 m is outside (0, 5] m"),
        ("base_height_m: .nan", "nan m is outside [0, 5] m"),
        ("battery_current_sign: 2", "2 is none of -1, 0 and 1"),
        ("odometry_yaw_rad: 90", "90.0 rad is more than half a turn"),
        ("odometry_yaw_rad: .nan", "nan rad is more than half a turn"),
        ("joint_names: [a, b, a]", "a named twice"),
        ("joint_names: a", "joint_names: wanted a list"),
        ("topics: {imu: [none, /imu]}", "'none' stands beside topics"),
        ("topics: {imu: ['']}", "an empty topic name"),
        ("mounting: {radar: {}}", "unknown sensors radar"),
        ("mounting: {imu: {rpy_rad: [0, 0, 90]}}", "radians, not degrees"),
        ("mounting: {imu: {xyz_m: [0, 0]}}", "mounting.imu.xyz_m: [0.0, 0.0] are not three finite numbers"),
        ("camera: {width: 640, height: 480, fx: 1, fy: 1, cx: 0}", "camera.cy: is missing"),
        ("camera: {width: 0, height: 1, fx: 1, fy: 1, cx: 0, cy: 0}", "camera.width: 0 px is not above 0"),
        (
            "camera: {width: 1, height: 1, fx: 1, fy: 1, cx: 0, cy: 0, distortion_model: fisheye9}",
            "camera.distortion_model: there is no distortion model 'fisheye9'",
        ),
        (
            "camera: {width: 1, height: 1, fx: 1, fy: 1, cx: 0, cy: 0, distortion: [0.1]}",
            "[0.1]: distortion model 'none' has 1 coefficients",
        ),
        ("cameras: {rear: {}}", "cameras.rear.topics: is missing"),
        ("cameras: {rear: {topics: []}}", "cameras.rear.topics: [] names no topic"),
        ("lidars: {roof: {topics: [none]}}", "lidars.roof.topics: ['none'] names no topic"),
        ("lidars: {roof: {topics: ['/']}}", "lidars.roof.topics: an empty topic name"),
        ("cameras: {front: {topics: [/a]}}", "cameras: a sensor cannot be called 'front'"),
        ("lidars: {Top.1: {topics: [/a]}}", "lidars: a sensor cannot be called 'Top.1'"),
        ("lidars: {roof: {topics: [/a], camera_info: [/b]}}", "lidars.roof.camera_info: there is no such key"),
        ("cameras: {rear: {topics: [/a], mounting: {rpy_rad: [0, 0, 90]}}}", "radians, not degrees"),
        ("cameras: {rear: {topics: [/a]}, rear: {topics: [/b]}}", "rear stands twice"),
        ("topics: {imu: [/imu]}\nname: a\ntopics: {camera: [/b]}", "topics stands twice"),
        ("- husky", "wanted keys and values, got a list"),
        ("name: [unclosed", "is not YAML"),
        ("!!python/object/apply:os.getcwd []", "is not YAML"),
    ],
)
def test_a_fault_is_named_with_file_and_cure(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text(text)
    with pytest.raises(NavtoolError) as caught:
        load_robot_file(path)
    assert said in str(caught.value)
    assert caught.value.where == str(path)
    assert caught.value.cure


def test_all_faults_of_a_file_are_named_at_once(tmp_path: Path) -> None:
    path = tmp_path / "robot.yaml"
    path.write_text("naem: husky\nwidth_m: wide\nbase_frame: 3\n")
    with pytest.raises(SettingError) as caught:
        load_robot_file(path)
    assert all(key in caught.value.what for key in ("naem", "width_m", "base_frame"))


def test_absent_files_and_folders_are_named(tmp_path: Path) -> None:
    with pytest.raises(DatasetsError, match="cannot be read"):
        load_robot_file(tmp_path / "absent.yaml")
    with pytest.raises(DatasetsError, match="cannot be written"):
        save_robot_file(RobotConfig(), tmp_path / "absent" / "robot.yaml")
