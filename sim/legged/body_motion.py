"""The body's pose and velocity as the controller reads them."""

import math
from typing import NamedTuple

import mujoco
import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array


class BodyMotion(NamedTuple):
    """Motion of the trunk; world frame unless named otherwise. Plain numbers: a controller does little with many."""

    rotation: Float64[Array, "3 3"]
    """From the body's axes to the world's."""
    position_m: list[float]
    centre_m: list[float]
    """Centre of mass of the whole robot."""
    velocity_mps: list[float]
    rates_radps: list[float]
    """In the body's axes."""
    yaw_rad: float
    cosine: float
    """Cosine of the yaw."""
    sine: float

    def ahead_left(self, x: float, y: float) -> tuple[float, float]:
        """Return a horizontal vector's parts along and across the heading."""
        return self.cosine * x + self.sine * y, -self.sine * x + self.cosine * y

    def from_heading(self, ahead: float, left: float) -> tuple[float, float]:
        """Return the horizontal vector in the world with these parts along and across the heading."""
        return self.cosine * ahead - self.sine * left, self.sine * ahead + self.cosine * left


def body_motion(data: mujoco.MjData, trunk: int) -> BodyMotion:
    """Return the motion now; `trunk` is the number of the body."""
    rotation = data.xmat[trunk].reshape(3, 3)
    yaw = math.atan2(rotation[1, 0], rotation[0, 0])
    velocity = data.qvel[:6].tolist()
    position = data.qpos[:3].tolist()
    centre = data.subtree_com[trunk].tolist()
    return BodyMotion(rotation, position, centre, velocity[:3], velocity[3:], yaw, math.cos(yaw), math.sin(yaw))


def upright(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Float64[Array, "3 3"]:
    """Return the rotation Rz(yaw) Ry(pitch) Rx(roll)."""
    cr, sr, cp, sp = math.cos(roll_rad), math.sin(roll_rad), math.cos(pitch_rad), math.sin(pitch_rad)
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
