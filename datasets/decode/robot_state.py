"""The robot's own state: joints, battery, and the plain values of ``std_msgs``."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from navtool.datasets.decode.header import NO_HEAD, head_of
from navtool.datasets.decode.messages import (
    BatterySample,
    BoolSample,
    FloatSample,
    JointSample,
    JoySample,
    StringSample,
)
from navtool.pipeline.arrays import Array


def decode_joint_state(message: Any) -> JointSample:
    """``sensor_msgs/JointState``: the longest of its lists sets the number of joints, the others are filled up."""
    lists = (message.name, message.position, message.velocity, message.effort)
    joints = max(len(values) for values in lists)
    return JointSample(
        **head_of(message)._asdict(),
        names=(*message.name, *[""] * (joints - len(message.name))),
        position=_filled(message.position, joints),
        velocity=_filled(message.velocity, joints),
        effort=_filled(message.effort, joints),
    )


def decode_battery_state(message: Any) -> BatterySample:
    """``sensor_msgs/BatteryState``: what the robot draws and has left."""
    return BatterySample(
        **head_of(message)._asdict(),
        current_a=float(message.current),
        voltage_v=float(message.voltage),
        percentage=float(message.percentage),
    )


def decode_bool(message: Any) -> BoolSample:
    """``std_msgs/Bool``."""
    return BoolSample(**NO_HEAD._asdict(), value=bool(message.data))


def decode_float(message: Any) -> FloatSample:
    """``std_msgs/Float32`` and ``std_msgs/Float64``."""
    return FloatSample(**NO_HEAD._asdict(), value=float(message.data))


def decode_joy(message: Any) -> JoySample:
    """``sensor_msgs/Joy``."""
    axes, buttons = (np.asarray(values, np.float64) for values in (message.axes, message.buttons))
    return JoySample(**head_of(message)._asdict(), axes=axes, buttons=buttons)


def decode_string(message: Any) -> StringSample:
    """``std_msgs/String``."""
    return StringSample(**NO_HEAD._asdict(), value=str(message.data))


def _filled(values: Any, joints: int) -> Float64[Array, " n"]:
    filled = np.full(joints, np.nan)
    filled[: len(values)] = values
    return filled
