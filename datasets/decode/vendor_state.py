"""The robot's own state in the messages of its vendor: by the names of their fields, whatever else a version has.

The definition that the recording embeds is used: the same type name has had several layouts.
"""

from typing import Any

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.header import NO_HEAD, Head, head_of, nanoseconds
from navtool.datasets.decode.messages import (
    BatterySample,
    BoolSample,
    ImuSample,
    JointSample,
    PoseSample,
    RobotStateSample,
)
from navtool.datasets.decode.robot_state import decode_joint_state

UNITREE_JOINTS = tuple(f"{leg}_{joint}_joint" for leg in ("FR", "FL", "RR", "RL") for joint in ("hip", "thigh", "calf"))
"""The order of the motors, as ``unitree_legged_sdk``'s quadruped.h has it."""
_MILLI = 1e-3
_SEPARATE_CURRENTS = 3
"""Currents that a Husky A200 measures, one by one; every other Clearpath platform measures more or fewer."""
_PEDAL_PRESSED = 200.0
"""Reading of a pedal beyond which its driver intervenes, as TartanDrive's own conversion has it."""


def decode_unitree_state(message: Any) -> RobotStateSample:
    """``LowState`` and ``HighState`` of ``unitree_go`` and ``unitree_legged_msgs``: joints, IMU and battery.

    Layouts differ: of the parts, and of header and stamp, each has some. Position in rad, velocity in rad/s, estimated
    torque in N m; the battery's current is recorded in mA, and the sign of a discharge is not documented.
    """
    head = _head_if_any(message)
    motors = _either(message, "motor_state", "motorState")
    imu, bms = _either(message, "imu_state", "imu"), _either(message, "bms_state", "bms")
    return RobotStateSample(
        **head._asdict(),
        joints=None if motors is None else _unitree_joints(head, motors),
        imu=None if imu is None else _unitree_imu(head, imu),
        battery=None if bms is None else _unitree_battery(head, bms, float(getattr(message, "power_v", np.nan))),
    )


def _unitree_joints(head: Head, motors: Any) -> JointSample:
    if len(motors) < len(UNITREE_JOINTS):
        raise DatasetsError(f"{len(motors)} motors, where {len(UNITREE_JOINTS)} are expected")
    legs = motors[: len(UNITREE_JOINTS)]
    return JointSample(
        **head._asdict(),
        names=UNITREE_JOINTS,
        position=np.array([motor.q for motor in legs], np.float64),
        velocity=np.array([motor.dq for motor in legs], np.float64),
        effort=np.array([_first(motor, "tau_est", "tauEst") for motor in legs], np.float64),
    )


def _unitree_imu(head: Head, imu: Any) -> ImuSample:
    return ImuSample(
        stamp_ns=head.stamp_ns,
        frame_id=head.frame_id or "imu_link",
        angular_velocity=np.asarray(imu.gyroscope, np.float64),
        linear_acceleration=np.asarray(imu.accelerometer, np.float64),
        orientation=np.roll(np.asarray(imu.quaternion, np.float64), -1),  # recorded as w, x, y, z
    )


def _unitree_battery(head: Head, bms: Any, voltage_v: float) -> BatterySample:
    return BatterySample(
        **head._asdict(),
        current_a=float(bms.current) * _MILLI,
        voltage_v=voltage_v,
        percentage=float(_first(bms, "soc", "SOC")) / 100.0,
    )


def decode_unitree_sport_state(message: Any) -> PoseSample:
    """``unitree_go/SportModeState``: the pose, by its own stamp.

    The frame of its velocity is not documented, so speeds are left to the differences of the poses.
    """
    return PoseSample(
        stamp_ns=nanoseconds(message.stamp),
        frame_id="odom",
        position=np.asarray(message.position, np.float64),
        orientation=np.roll(np.asarray(message.imu_state.quaternion, np.float64), -1),
    )


def decode_anymal_state(message: Any) -> JointSample:
    """``anymal_msgs/AnymalState``: its joints."""
    return decode_joint_state(message.joints)


def decode_anymal_battery(message: Any) -> BatterySample:
    """``anymal_msgs/BatteryState``: neither the units nor the sign of a discharge are documented; A and V are taken.

    The state of charge counts as per cent where it is beyond 1.
    """
    charge = float(message.state_of_charge)
    return BatterySample(
        **head_of(message)._asdict(),
        current_a=float(message.current),
        voltage_v=float(message.voltage),
        percentage=charge / 100.0 if charge > 1.0 else charge,
    )


def decode_spot_batteries(message: Any) -> BatterySample:
    """``spot_msgs/BatteryStateArray``: the batteries together; positive while charging, as the driver documents."""
    batteries = message.battery_states
    if not batteries:
        raise DatasetsError("no battery in the message")
    return BatterySample(
        **head_of(batteries[0])._asdict(),
        current_a=float(sum(battery.current for battery in batteries)),
        voltage_v=float(batteries[0].voltage),
        percentage=float(np.mean([battery.charge_percentage for battery in batteries])) / 100.0,
    )


def decode_husky_status(message: Any) -> RobotStateSample:
    """``husky_msgs/HuskyStatus``: what both drives and the rest draw together, as a discharge; the emergency stop."""
    drawn = message.left_driver_current + message.right_driver_current + message.mcu_and_user_port_current
    return _drawn_and_stopped(message, drawn, _either(message, "battery_voltage"), _either(message, "e_stop"))


def decode_warthog_status(message: Any) -> RobotStateSample:
    """``warthog_msgs/Status``: what the robot draws in all, as a discharge; whether a stop was pressed."""
    voltage = _either(message, "measured_battery")
    return _drawn_and_stopped(message, message.current_battery, voltage, _either(message, "stop_engaged"))


def decode_jackal_status(message: Any) -> BatterySample:
    """``jackal_msgs/Status``: what the robot draws in all, as a discharge."""
    return _drawn(head_of(message), _first(message, "total_current"), _either(message, "measured_battery"))


def decode_clearpath_power(message: Any) -> BatterySample:
    """``clearpath_platform_msgs/Power``: what the robot draws in all, as a discharge.

    The message does not name its platform, but each measures another number of currents: three are those of the Husky
    A200, for its user ports and either drive, which together are what it draws. Of all others the first is the total
    (Jackal, Dingo, Warthog, Ridgeback) or the battery's (A300). The first voltage is the battery's on each.
    """
    currents, voltages = np.asarray(message.measured_currents), np.asarray(message.measured_voltages)
    if not currents.size:
        raise DatasetsError("the platform measures no current", cure="name another topic for battery")
    drawn = currents.sum() if currents.size == _SEPARATE_CURRENTS else currents[0]
    return _drawn(head_of(message), drawn, voltages[0] if voltages.size else None)


def decode_racepak_controls(message: Any) -> BoolSample:
    """``racepak/rp_controls``, the pedals of a vehicle that drives by itself: whether somebody presses one."""
    pressed = message.throttle > _PEDAL_PRESSED or message.brake > _PEDAL_PRESSED
    return BoolSample(**NO_HEAD._asdict(), value=bool(pressed))


def _drawn(head: Head, current_a: Any, voltage_v: Any) -> BatterySample:
    voltage = np.nan if voltage_v is None else float(voltage_v)
    return BatterySample(**head._asdict(), current_a=-float(current_a), voltage_v=voltage, percentage=np.nan)


def _drawn_and_stopped(message: Any, current_a: Any, voltage_v: Any, stopped: Any) -> RobotStateSample:
    head = head_of(message)
    return RobotStateSample(
        **head._asdict(),
        battery=_drawn(head, current_a, voltage_v),
        intervention=None if stopped is None else BoolSample(**head._asdict(), value=bool(stopped)),
    )


def _head_if_any(message: Any) -> Head:
    """The head of a message of a type that has none in most of its layouts."""
    if hasattr(message, "header"):
        return head_of(message)
    return Head(nanoseconds(message.stamp), "") if hasattr(message, "stamp") else NO_HEAD


def _either(message: Any, *names: str) -> Any:
    """The field under the first of its names that the message has; None where it has none of them."""
    return next((getattr(message, name) for name in names if hasattr(message, name)), None)


def _first(message: Any, *names: str) -> Any:
    """The field under the first of its names that the message has.

    Raises:
        DatasetsError: It has none of them.
    """
    found = _either(message, *names)
    if found is None:
        raise DatasetsError(f"a message without {' or '.join(names)}")
    return found
