"""Every other message: what is written into its fields comes out, and nothing else."""

import math
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from navtool.base.errors import DatasetsError
from navtool.datasets.decode import messages as m
from navtool.datasets.decode.table import MESSAGES
from navtool.datasets.recording import open_recording
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion

STAMP_NS = 1_700_000_000_123_456_789
HEAD = {"header": {"stamp": {"sec": 1_700_000_000, "nanosec": 123_456_789}, "frame_id": "frame"}}
VECTOR = {"x": 1.0, "y": -2.0, "z": 3.5}
TURN = {"x": 0.0, "y": 0.0, "z": 0.6, "w": 0.8}
POSE = {"position": VECTOR, "orientation": TURN}
TWIST = {"linear": VECTOR, "angular": {"x": 0.1, "y": 0.2, "z": -0.3}}
type Make = Callable[..., Any]


@pytest.fixture(params=[False, True], ids=["ros2", "ros1"])
def decode(request: pytest.FixtureRequest, ros_message: Make) -> Callable[..., Any]:
    """``decode(type, fields)`` by each serialisation in turn."""

    def decoded(kind: str, fields: dict[str, Any]) -> Any:
        return MESSAGES[kind].decode(ros_message(kind, fields, ros1=request.param))

    return decoded


def assert_head(sample: Any) -> None:
    assert (sample.stamp_ns, sample.frame_id) == (STAMP_NS, "frame")


def assert_no_head(sample: Any) -> None:
    assert (sample.stamp_ns, sample.frame_id) == (None, "")


def test_odometry(decode: Make) -> None:
    fields = {**HEAD, "child_frame_id": "base", "pose": {"pose": POSE}, "twist": {"twist": TWIST}}
    sample = decode("nav_msgs/msg/Odometry", fields)
    assert isinstance(sample, m.OdometrySample)
    assert_head(sample)
    assert sample.child_frame_id == "base"
    assert sample.position.tolist() == [1.0, -2.0, 3.5]
    assert sample.orientation.tolist() == [0.0, 0.0, 0.6, 0.8]
    assert sample.linear.tolist() == [1.0, -2.0, 3.5]
    assert sample.angular.tolist() == [0.1, 0.2, -0.3]


@pytest.mark.parametrize(("covariance", "estimated"), [(-1.0, False), (0.0, True), (0.01, True)])
def test_imu_without_an_orientation_says_so_in_its_covariance(covariance: float, estimated: bool, decode: Make) -> None:
    fields = {
        **HEAD,
        "orientation": TURN,
        "orientation_covariance": [covariance, *[0.0] * 8],
        "angular_velocity": TWIST["angular"],
        "linear_acceleration": VECTOR,
    }
    sample = decode("sensor_msgs/msg/Imu", fields)
    assert isinstance(sample, m.ImuSample)
    assert_head(sample)
    assert sample.angular_velocity.tolist() == [0.1, 0.2, -0.3]
    assert sample.linear_acceleration.tolist() == [1.0, -2.0, 3.5]
    assert (sample.orientation is not None) == estimated
    if sample.orientation is not None:
        assert sample.orientation.tolist() == [0.0, 0.0, 0.6, 0.8]


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("geometry_msgs/msg/Twist", TWIST),
        ("geometry_msgs/msg/TwistStamped", {**HEAD, "twist": TWIST}),
        ("geometry_msgs/msg/TwistWithCovarianceStamped", {**HEAD, "twist": {"twist": TWIST}}),
    ],
)
def test_twists(kind: str, fields: dict[str, Any], decode: Make) -> None:
    sample = decode(kind, fields)
    assert isinstance(sample, m.TwistSample)
    (assert_no_head if kind.endswith("/Twist") else assert_head)(sample)
    assert sample.linear.tolist() == [1.0, -2.0, 3.5]
    assert sample.angular.tolist() == [0.1, 0.2, -0.3]


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("geometry_msgs/msg/PoseStamped", {**HEAD, "pose": POSE}),
        ("geometry_msgs/msg/PoseWithCovarianceStamped", {**HEAD, "pose": {"pose": POSE}}),
    ],
)
def test_poses(kind: str, fields: dict[str, Any], decode: Make) -> None:
    sample = decode(kind, fields)
    assert isinstance(sample, m.PoseSample)
    assert_head(sample)
    assert sample.position.tolist() == [1.0, -2.0, 3.5]
    assert sample.orientation.tolist() == [0.0, 0.0, 0.6, 0.8]


numbers = st.lists(st.floats(allow_nan=True, width=64), max_size=4)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=60, deadline=None)
@given(names=st.lists(st.text("abc", max_size=3), max_size=4), position=numbers, velocity=numbers, effort=numbers)
def test_joint_lists_of_any_length_are_filled_up_to_the_longest(
    names: list[str], position: list[float], velocity: list[float], effort: list[float], decode: Make
) -> None:
    fields = {**HEAD, "name": names, "position": position, "velocity": velocity, "effort": effort}
    sample = decode("sensor_msgs/msg/JointState", fields)
    assert isinstance(sample, m.JointSample)
    assert_head(sample)
    joints = max(len(names), len(position), len(velocity), len(effort))
    assert sample.names == (*names, *[""] * (joints - len(names)))
    for values, given_values in ((sample.position, position), (sample.velocity, velocity), (sample.effort, effort)):
        np.testing.assert_array_equal(values, [*given_values, *[math.nan] * (joints - len(given_values))])


def test_battery(decode: Make) -> None:
    fields = {**HEAD, "current": -2.5, "voltage": 48.25, "percentage": math.nan}
    sample = decode("sensor_msgs/msg/BatteryState", fields)
    assert isinstance(sample, m.BatterySample)
    assert_head(sample)
    assert (sample.current_a, sample.voltage_v) == (-2.5, 48.25)
    assert math.isnan(sample.percentage)


CALIBRATION = {
    **HEAD,
    "width": 640,
    "height": 480,
    "distortion_model": "plumb_bob",
    "d": [0.1, -0.2, 0.001, 0.002, 0.0],
    "k": [500.0, 0.0, 321.0, 0.0, 510.0, 242.0, 0.0, 0.0, 1.0],
    "r": np.eye(3).reshape(-1),
    "p": [480.0, 0.0, 320.0, -50.0, 0.0, 480.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0],
}


def test_a_calibration_in_the_upper_case_of_ros1_and_the_lower_case_of_ros2(decode: Make) -> None:
    sample = decode("sensor_msgs/msg/CameraInfo", CALIBRATION)
    assert isinstance(sample, m.CameraInfoSample)
    assert_head(sample)
    assert sample.camera == CameraModel(
        640, 480, 500.0, 510.0, 321.0, 242.0, "plumb_bob", (0.1, -0.2, 0.001, 0.002, 0.0)
    )
    np.testing.assert_array_equal(sample.rectification, np.eye(3))
    assert sample.projection.tolist() == [[480, 0, 320, -50], [0, 480, 240, 0], [0, 0, 1, 0]]


def test_a_calibration_without_a_lens_model_is_of_an_ideal_lens(decode: Make) -> None:
    sample = decode("sensor_msgs/msg/CameraInfo", {**CALIBRATION, "distortion_model": "", "d": []})
    assert (sample.camera.distortion_model, sample.camera.distortion) == ("none", ())


@pytest.mark.parametrize(
    "change",
    [
        {"k": np.zeros(9)},
        {"distortion_model": "magic"},
        {"width": 0},
        {"p": np.full(12, np.nan)},
        {"r": np.full(9, np.inf)},
        {"d": [1e300, 0.0, 0.0, 0.0, 0.0]},
        {"k": [1e308, 0.0, 321.0, 0.0, 1e308, 242.0, 0.0, 0.0, 1.0]},
    ],
)
def test_a_camera_that_is_not_calibrated_is_refused(change: dict[str, Any], decode: Make) -> None:
    with pytest.raises(DatasetsError, match=r"this calibration cannot be used(.|\n)*cure"):
        decode("sensor_msgs/msg/CameraInfo", {**CALIBRATION, **change})


def transform_fields(child: str, rotation: dict[str, float]) -> dict[str, Any]:
    return {**HEAD, "child_frame_id": child, "transform": {"translation": VECTOR, "rotation": rotation}}


@pytest.mark.parametrize("kind", ["tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"])
def test_transforms_are_poses_of_the_child_in_the_parent(kind: str, decode: Make) -> None:
    sample = decode(kind, {"transforms": [transform_fields("lidar", TURN), transform_fields("imu", TURN)]})
    assert isinstance(sample, m.TransformsSample)
    assert_no_head(sample)
    assert [(x.parent, x.child, x.stamp_ns) for x in sample.transforms] == [
        ("frame", "lidar", STAMP_NS),
        ("frame", "imu", STAMP_NS),
    ]
    expected = transform_from_xyz_quaternion(np.array([1.0, -2.0, 3.5]), np.array([0.0, 0.0, 0.6, 0.8]))
    for transform in sample.transforms:
        np.testing.assert_array_equal(transform.matrix, expected)


def test_a_transform_without_a_rotation_is_refused_by_name(decode: Make) -> None:
    lost = {"transforms": [transform_fields("lidar", {"x": 0.0, "y": 0.0, "z": 0.0, "w": 0.0})]}
    with pytest.raises(DatasetsError, match="from frame to lidar"):
        decode("tf2_msgs/msg/TFMessage", lost)


@pytest.mark.parametrize("number", [math.nan, math.inf, 1e300])
@pytest.mark.parametrize("part", ["translation", "rotation"])
def test_a_transform_of_numbers_beyond_all_measure_is_refused_by_name(part: str, number: float, decode: Make) -> None:
    lost = transform_fields("lidar", TURN)
    lost["transform"] = {**lost["transform"], part: {**lost["transform"][part], "y": number}}
    with pytest.raises(DatasetsError, match="from frame to lidar has the numbers"):
        decode("tf2_msgs/msg/TFMessage", {"transforms": [lost]})


@pytest.mark.parametrize(("status", "has_fix"), [(-1, False), (0, True), (2, True)])
def test_a_satellite_fix(status: int, has_fix: bool, decode: Make) -> None:
    fields = {**HEAD, "latitude": 47.5, "longitude": -8.25, "altitude": math.nan, "status": {"status": status}}
    sample = decode("sensor_msgs/msg/NavSatFix", fields)
    assert isinstance(sample, m.NavSatSample)
    assert_head(sample)
    assert (sample.latitude_deg, sample.longitude_deg, sample.has_fix) == (47.5, -8.25, has_fix)
    assert math.isnan(sample.altitude_m)


@pytest.mark.parametrize(
    ("kind", "value", "sample_type"),
    [
        ("std_msgs/msg/Bool", True, m.BoolSample),
        ("std_msgs/msg/Bool", False, m.BoolSample),
        ("std_msgs/msg/Float32", 1.25, m.FloatSample),
        ("std_msgs/msg/Float64", 0.1, m.FloatSample),
        ("std_msgs/msg/String", "größer", m.StringSample),
    ],
)
def test_plain_values(kind: str, value: Any, sample_type: type, decode: Make) -> None:
    sample = decode(kind, {"data": value})
    assert isinstance(sample, sample_type)
    assert_no_head(sample)
    assert getattr(sample, "value", None) == value


IMAGE = {"width": 2, "height": 1, "encoding": "rgb8", "step": 6, "data": np.arange(6)}
CLOUD: dict[str, Any] = {
    "width": 2,
    "height": 1,
    "fields": [{"name": name, "offset": 4 * k, "datatype": 7, "count": 1} for k, name in enumerate("xyz")],
    "point_step": 12,
    "row_step": 24,
    "data": np.arange(6, dtype=np.float32).view(np.uint8),
}
ANY_FIELDS: dict[str, dict[str, Any]] = {
    "sensor_msgs/msg/Image": IMAGE,
    "sensor_msgs/msg/CompressedImage": {"format": "png", "data": cv2.imencode(".png", np.zeros((2, 3, 3)))[1]},
    "sensor_msgs/msg/PointCloud2": CLOUD,
    "sensor_msgs/msg/CameraInfo": CALIBRATION,
    **{
        f"{package}/msg/CompressedPointCloud2": {
            **{name: value for name, value in CLOUD.items() if name != "data"},
            "compressed_data": np.frombuffer(zlib.compress(CLOUD["data"].tobytes()), np.uint8),
        }
        for package in ("point_cloud_interfaces", "draco_point_cloud_transport")
    },
    "ffmpeg_image_transport_msgs/msg/FFMPEGPacket": {
        "encoding": "hevc",
        "data": np.frombuffer(b"\0\0\0\1&\1", np.uint8),
    },
    "velodyne_msgs/msg/VelodyneScan": {"packets": [{"data": np.r_[np.full(1205, 1), 0x22]}]},
    "tf2_msgs/msg/TFMessage": {"transforms": [transform_fields("lidar", TURN)]},
    "tf/msg/tfMessage": {"transforms": [transform_fields("imu", TURN)]},
}


def test_every_type_goes_through_every_container(
    container: str, write_recording: Callable[..., Path], ros_message: Make
) -> None:
    kinds = sorted(kind for kind, row in MESSAGES.items() if not kind.startswith("foxglove") and not row.own_definition)
    fields = [{**HEAD, **ANY_FIELDS.get(kind, {})} for kind in kinds]
    entries = [(f"/{k}", kind, 10 + k, fields[k]) for k, kind in enumerate(kinds)]
    path = write_recording(container, entries)
    with open_recording(path) as recording:
        raws = list(recording.messages({topic.name for topic in recording.topics}))
        assert [raw.type for raw in raws] == kinds
        for raw, given_fields in zip(raws, fields, strict=True):
            sample = recording.decode(raw)
            expected = MESSAGES[raw.type].decode(ros_message(raw.type, given_fields))
            assert sample.stamp_ns == recording.header_stamp_ns(raw)
            assert_equal(sample, expected)


def assert_equal(sample: Any, expected: Any) -> None:
    """Equal in every field, arrays by value."""
    assert type(sample) is type(expected)
    for name in sample.__dataclass_fields__:
        one, other = getattr(sample, name), getattr(expected, name)
        if isinstance(one, np.ndarray):
            np.testing.assert_array_equal(one, other)
        elif name == "transforms":
            for transform, expected_transform in zip(one, other, strict=True):
                assert_equal(transform, expected_transform)
        else:
            assert one == other
