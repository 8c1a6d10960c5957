"""The robot's own state in the messages of its vendor: by the names of their fields, whatever else a version has.

The definition that the recording embeds is used: the same type name has had several layouts.
"""

from typing import Any

import numpy as np

from navtool.datasets.decode.header import head_of, nanoseconds
from navtool.datasets.decode.messages import BatterySample, ImuSample, JointSample, PoseSample, RobotStateSample
from navtool.datasets.decode.robot_state import decode_joint_state
from navtool.datasets.errors import DatasetsError

UNITREE_JOINTS = tuple(f"{leg}_{joint}_joint" for leg in ("FR", "FL", "RR", "RL") for joint in ("hip", "thigh", "calf"))
"""The order of the motors, as ``unitree_legged_sdk``'s quadruped.h has it."""
_MILLI = 1e-3


def decode_unitree_low_state(message: Any) -> RobotStateSample:
    """``unitree_go/LowState`` and ``unitree_legged_msgs/LowState``: joints, IMU and battery; neither has a header.

    Position in rad, velocity in rad/s, estimated torque in N m; the battery's current is recorded in mA.
    """
    motors = _first(message, "motor_state", "motorState")[: len(UNITREE_JOINTS)]
    if len(motors) < len(UNITREE_JOINTS):
        raise DatasetsError(f"{len(motors)} motors, where {len(UNITREE_JOINTS)} are expected")
    imu, bms = _first(message, "imu_state", "imu"), _first(message, "bms_state", "bms")
    return RobotStateSample(
        stamp_ns=None,
        frame_id="",
        joints=JointSample(
            stamp_ns=None,
            frame_id="",
            names=UNITREE_JOINTS,
            position=np.array([motor.q for motor in motors], np.float64),
            velocity=np.array([motor.dq for motor in motors], np.float64),
            effort=np.array([_first(motor, "tau_est", "tauEst") for motor in motors], np.float64),
        ),
        imu=ImuSample(
            stamp_ns=None,
            frame_id="imu_link",
            angular_velocity=np.asarray(imu.gyroscope, np.float64),
            linear_acceleration=np.asarray(imu.accelerometer, np.float64),
            orientation=np.roll(np.asarray(imu.quaternion, np.float64), -1),  # recorded as w, x, y, z
        ),
        battery=BatterySample(
            stamp_ns=None,
            frame_id="",
            current_a=float(bms.current) * _MILLI,
            voltage_v=float(getattr(message, "power_v", np.nan)),
            percentage=float(_first(bms, "soc", "SOC")) / 100.0,
        ),
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


def decode_husky_status(message: Any) -> BatterySample:
    """``husky_msgs/HuskyStatus``: what both drives and the rest draw together, as a discharge."""
    drawn = message.left_driver_current + message.right_driver_current + message.mcu_and_user_port_current
    return _drawn(message, float(drawn))


def decode_jackal_status(message: Any) -> BatterySample:
    """``jackal_msgs/Status``: what the robot draws, as a discharge."""
    return _drawn(message, float(message.total_current))


def _drawn(message: Any, current_a: float) -> BatterySample:
    return BatterySample(**head_of(message)._asdict(), current_a=-current_a, voltage_v=np.nan, percentage=np.nan)


def _first(message: Any, *names: str) -> Any:
    """The field under the first of its names that the message has.

    Raises:
        DatasetsError: It has none of them.
    """
    for name in names:
        if hasattr(message, name):
            return getattr(message, name)
    raise DatasetsError(f"a message without {' or '.join(names)}")
