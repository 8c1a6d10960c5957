"""The vendors' own messages: by the names of their fields, in whatever layout the recording embeds."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.decode import messages as m
from navtool.datasets.decode.table import MESSAGES
from navtool.datasets.decode.vendor_state import UNITREE_JOINTS
from navtool.datasets.recording import open_recording
from navtool.datasets.streams.rows import rows_of

STAMP_NS = 1_700_000_000_123_456_789
STAMP = {"sec": 1_700_000_000, "nanosec": 123_456_789}
HEAD = {"header": {"stamp": STAMP, "frame_id": "frame"}}
IMU = {"quaternion": [0.5, 0.5, -0.5, 0.5], "gyroscope": [0.25, 0.5, -0.5], "accelerometer": [1.0, 2.0, 9.75]}
type Make = Callable[..., Any]


@pytest.fixture(params=[False, True], ids=["ros2", "ros1"])
def decode(request: pytest.FixtureRequest, ros_message: Make) -> Callable[..., Any]:
    """``decode(type, fields, types=())`` by each serialisation in turn."""

    def decoded(kind: str, fields: dict[str, Any], **layout: Any) -> Any:
        return MESSAGES[kind].decode(ros_message(kind, fields, ros1=request.param, **layout))

    return decoded


@pytest.mark.parametrize(
    ("kind", "fields", "current_a", "voltage_v"),
    [
        (
            "warthog_msgs/msg/Status",
            {"current_battery": 12.5, "current_48v": 1.0, "measured_battery": 51.5},
            12.5,
            51.5,
        ),
        (
            "husky_msgs/msg/HuskyStatus",
            {
                "left_driver_current": 1.5,
                "right_driver_current": 2.0,
                "mcu_and_user_port_current": 0.5,
                "battery_voltage": 26.25,
            },
            4.0,
            26.25,
        ),
        ("jackal_msgs/msg/Status", {"total_current": 3.5, "drive_current": 1.0, "measured_battery": 27.5}, 3.5, 27.5),
        # The number of currents tells a Husky A200 from all others: Ridgeback, Dingo, Jackal, Warthog, A300.
        ("clearpath_platform_msgs/msg/Power", {"measured_currents": [2.5]}, 2.5, math.nan),
        ("clearpath_platform_msgs/msg/Power", {"measured_currents": [2.5, 1.0]}, 2.5, math.nan),
        (
            "clearpath_platform_msgs/msg/Power",
            {"measured_currents": [0.5, 1.5, 2.0], "measured_voltages": [25.5, 24.0, 24.0]},
            4.0,
            25.5,
        ),
        (
            "clearpath_platform_msgs/msg/Power",
            {"measured_currents": [2.5, 1.0, 1.0, 0.5], "measured_voltages": [26.0, 5.0, 12.0]},
            2.5,
            26.0,
        ),
        ("clearpath_platform_msgs/msg/Power", {"measured_currents": [7.5, 1.0, 1.0, 0.5, 3.0]}, 7.5, math.nan),
        ("clearpath_platform_msgs/msg/Power", {"measured_currents": np.arange(6.5, 19.5)}, 6.5, math.nan),
    ],
)
def test_what_a_robot_draws_is_a_discharge(
    kind: str, fields: dict[str, Any], current_a: float, voltage_v: float, decode: Make
) -> None:
    sample = decode(kind, {**HEAD, **fields})
    battery = sample if isinstance(sample, m.BatterySample) else sample.battery
    assert (battery.stamp_ns, battery.frame_id) == (STAMP_NS, "frame")
    assert battery.current_a == -current_a, "sensor_msgs has a discharge as negative"
    np.testing.assert_equal(battery.voltage_v, voltage_v)


def test_a_platform_without_currents_is_refused(decode: Make) -> None:
    with pytest.raises(DatasetsError, match="measures no current"):
        decode("clearpath_platform_msgs/msg/Power", HEAD)


@pytest.mark.parametrize(("charge", "percentage"), [(0.75, 0.75), (75.0, 0.75), (1.0, 1.0)])
@pytest.mark.parametrize("current", [-6.5, 6.5])
def test_the_battery_of_an_anymal_is_as_recorded(
    charge: float, percentage: float, current: float, decode: Make
) -> None:
    sample = decode(
        "anymal_msgs/msg/BatteryState", {**HEAD, "current": current, "voltage": 50.0, "state_of_charge": charge}
    )
    assert (sample.stamp_ns, sample.current_a, sample.voltage_v) == (STAMP_NS, current, 50.0)
    assert sample.percentage == percentage


@pytest.mark.parametrize("stopped", [False, True])
@pytest.mark.parametrize(
    ("kind", "flag"), [("warthog_msgs/msg/Status", "stop_engaged"), ("husky_msgs/msg/HuskyStatus", "e_stop")]
)
def test_one_message_tells_of_battery_and_stop(kind: str, flag: str, stopped: bool, decode: Make) -> None:
    sample = decode(kind, {**HEAD, flag: stopped})
    row = rows_of(sample, "intervention", None)
    assert (row.stamp_ns, row.columns, row.values) == (STAMP_NS, ("active",), (float(stopped),))
    assert rows_of(sample, "battery", None).columns[0] == "current_a"
    with pytest.raises(DatasetsError, match="the message holds no joints"):
        rows_of(sample, "joints", None)


@pytest.mark.parametrize(
    ("throttle", "brake", "active"),
    [(0, 0, False), (200, 200, False), (200.5, 0, True), (0, 201, True), (400, 400, True)],
)
def test_a_pressed_pedal_is_an_intervention(throttle: float, brake: float, active: bool, decode: Make) -> None:
    sample = decode("racepak/msg/rp_controls", {"throttle": throttle, "brake": brake})
    assert sample == m.BoolSample(stamp_ns=None, frame_id="", value=active)


def motors(torque: str) -> list[dict[str, float]]:
    return [{"q": k, "dq": 2 * k, torque: 3 * k} for k in range(20)]


IMU_FIELD, BMS_FIELD = "unitree_legged_msgs/IMU imu", "unitree_legged_msgs/BmsState bms"
MOTORS = "unitree_legged_msgs/MotorState[20]"
LAYOUTS: dict[str, tuple[str, dict[str, Any], set[str], int | None]] = {
    "Go1": (
        f"uint8[2] head\n{IMU_FIELD}\n{MOTORS} motorState\n{BMS_FIELD}\nint16[4] footForce\nfloat32[3] position",
        {"imu": IMU, "motorState": motors("tauEst"), "bms": {"current": -3250, "SOC": 80}},
        {"joints", "imu", "battery"},
        None,
    ),
    "A1 with a header": (
        f"std_msgs/Header header\nuint8 mode\n{IMU_FIELD}\n{MOTORS} motorState\nint16[4] footForce",
        {**HEAD, "imu": IMU, "motorState": motors("tauEst")},
        {"joints", "imu"},
        STAMP_NS,
    ),
    "stamp first, other names": (
        f"builtin_interfaces/Time stamp\nuint8[2] head\n{IMU_FIELD}\n{MOTORS} motor_state\n{BMS_FIELD}",
        {"stamp": STAMP, "imu": IMU, "motor_state": motors("tauEst"), "bms": {"current": -3250, "SOC": 80}},
        {"joints", "imu", "battery"},
        STAMP_NS,
    ),
    "Aliengo": (
        f"uint8 levelFlag\nuint8 mode\n{IMU_FIELD}\nfloat32 forwardSpeed\nint16[4] footForce\nuint32 tick",
        {"imu": IMU},
        {"imu"},
        None,
    ),
}
"""Layouts of unitree_legged_msgs/HighState: definition, fields, the streams it holds, its stamp."""


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("container", ["ros1", "mcap"])
def test_a_high_state_is_read_with_the_definition_in_the_recording(
    layout: str, container: str, write_recording: Callable[..., Path]
) -> None:
    kind = "unitree_legged_msgs/msg/HighState"
    definition, fields, streams, stamp_ns = LAYOUTS[layout]
    path = write_recording(container, [("/high_state", kind, 10, fields)], types=((kind, definition),))
    with open_recording(path) as recording:
        (raw,) = recording.messages(["/high_state"])
        sample = recording.decode(raw)
        assert recording.header_stamp_ns(raw) == sample.stamp_ns == stamp_ns
    assert isinstance(sample, m.RobotStateSample)
    held = {name: getattr(sample, name) for name in ("joints", "imu", "battery", "intervention")}
    assert {name for name, part in held.items() if part is not None} == streams
    assert all(part.stamp_ns == stamp_ns for part in held.values() if part is not None)
    if sample.joints is not None:
        assert sample.joints.names == UNITREE_JOINTS
        for values, factor in ((sample.joints.position, 1), (sample.joints.velocity, 2), (sample.joints.effort, 3)):
            assert values.tolist() == [factor * k for k in range(12)], "the eight motors beyond the legs' are no joints"
    if sample.imu is not None:
        assert sample.imu.angular_velocity.tolist() == IMU["gyroscope"]
        assert sample.imu.linear_acceleration.tolist() == IMU["accelerometer"]
        assert sample.imu.orientation is not None
        assert sample.imu.orientation.tolist() == [0.5, -0.5, 0.5, 0.5], "w comes first in the message"
    if sample.battery is not None:
        assert sample.battery.current_a == pytest.approx(-3.25), "recorded in mA"
        assert sample.battery.percentage == pytest.approx(0.8)


def test_the_low_state_of_a_go2_is_read_alike(decode: Make) -> None:
    bms = {"current": 2500, "soc": 55}
    fields = {"imu_state": IMU, "motor_state": motors("tau_est"), "bms_state": bms, "power_v": 28.5}
    sample = decode("unitree_go/msg/LowState", fields)
    assert sample.joints.effort.tolist() == [3 * k for k in range(12)]
    assert (sample.battery.current_a, sample.battery.voltage_v) == (pytest.approx(2.5), 28.5)
    assert (sample.stamp_ns, sample.imu.stamp_ns, sample.battery.stamp_ns) == (None, None, None)


def test_every_vendor_type_can_be_named_for_a_stream() -> None:
    vendors = [row for row in MESSAGES.values() if row.own_definition]
    assert vendors
    assert all(row.named for row in vendors)
