"""Drives along arcs on level ground, with measurements without errors."""

import numpy as np

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_from_rpy
from navtool.sim.drive.drive import Drive, Measured
from navtool.sim.drive.failure import Failure

STEP_S = 0.01
JOINTS = ("left_wheel", "right_wheel")
_WHEEL_M, _TRACK_M = 0.165, 0.55


def arc_drive(
    seconds: float = 3.0,
    speed_mps: float = 0.8,
    turn_radps: float = 0.3,
    *,
    start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    height_m: float = 0.165,
    failures: tuple[Failure, ...] = (),
) -> Drive:
    """A drive at constant speed and turn from x, y and yaw, with base_link at a height above z = 0."""
    time_s = np.arange(round(seconds / STEP_S) + 1) * STEP_S
    ahead, left, yaw = _arc(time_s, speed_mps, turn_radps)
    cos, sin = np.cos(start[2]), np.sin(start[2])
    x, y = start[0] + cos * ahead - sin * left, start[1] + sin * ahead + cos * left
    steps, zero = time_s.size, np.zeros(time_s.size)
    wheels = (speed_mps + np.array([-1, 1]) * turn_radps * _TRACK_M / 2) / _WHEEL_M
    turning = np.broadcast_to(wheels, (steps, 2))
    joints = np.stack([time_s[:, None] * wheels, turning, 0.1 * turning], axis=1)
    ticks = slice(None, None, 2)
    return Drive(
        time_s=time_s,
        position_m=np.stack([x, y, zero + height_m], axis=1),
        quaternion=quaternion_from_rpy(np.stack([zero, zero, start[2] + yaw], axis=1)),
        velocity_mps=np.tile([speed_mps, 0.0, 0.0], (steps, 1)),
        rates_radps=np.tile([0.0, 0.0, turn_radps], (steps, 1)),
        command=np.tile([speed_mps, turn_radps], (steps, 1)),
        intervention=np.zeros(steps, bool),
        imu=Measured(time_s, np.tile([0.0, speed_mps * turn_radps, 9.81, 0.0, 0.0, turn_radps], (steps, 1))),
        joints=Measured(time_s[ticks], joints[ticks]),
        joint_names=JOINTS,
        odometry=Measured(
            time_s[ticks], np.stack([ahead, left, yaw, zero + speed_mps, zero + turn_radps], axis=1)[ticks]
        ),
        battery=Measured(time_s[::10], np.tile([-3.0, 26.0], (len(time_s[::10]), 1))),
        failures=failures,
    )


def _arc(time_s: Array, speed_mps: float, turn_radps: float) -> tuple[Array, Array, Array]:
    yaw = turn_radps * time_s
    if turn_radps == 0:
        return speed_mps * time_s, 0 * time_s, yaw
    radius = speed_mps / turn_radps
    return radius * np.sin(yaw), radius * (1 - np.cos(yaw)), yaw
