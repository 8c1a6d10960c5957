"""What force and torque the ground shall exert on the body so that it moves as commanded and stays upright."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.legged.body import HIP_OFFSET_M, HIPS_M, LEG_KG, MASS_KG, TRUNK_BOX_M, TRUNK_KG
from navtool.sim.legged.body_motion import BodyMotion, upright
from navtool.sim.legged.controller_config import CONTROL_S, ControllerConfig
from navtool.sim.legged.support_plane import SupportPlane

_MOST_PUSH_MPS2 = 4.0
_MOST_INTEGRAL_MPS2 = 1.5
_SINK_MPS2, _LIFT_MPS2 = -6.0, 12.0
_MOST_YAW_LAG_RAD = 0.15
_ROLL_SHARE, _PITCH_SHARE = 0.3, 0.6
"""How much of the ground's slope the body takes on."""


class Sway(NamedTuple):
    """How the centre of mass shall move over the feet."""

    ahead_m: float
    """How far ahead of it is where it shall be."""
    left_m: float
    speed_mps: float
    """To the left, as the gait asks for."""
    acceleration_mps2: float


class Balance:
    """Keeps speed, height and attitude."""

    def __init__(self, config: ControllerConfig, yaw_rad: float) -> None:
        self._config = config
        self._yaw_rad = yaw_rad
        self._lasting_mps2 = 0.0
        self._inertia = _standing_inertia()

    def wrench(
        self,
        body: BodyMotion,
        bias: Float64[Array, "6"],
        plane: SupportPlane,
        command: tuple[float, float],
        sway: Sway,
    ) -> Float64[Array, "6"]:
        """Return force (world axes) and torque (body's axes).

        Args:
            body: The body's motion.
            bias: The wrench that holds the whole robot against gravity and its own legs' motion.
            plane: The ground.
            command: Speed and turn to keep.
            sway: Motion over the feet.
        """
        speed, turn = command
        push, shove = self._across(body, speed, sway)
        force_x, force_y = body.from_heading(push, shove)
        lift = self._lift(body, plane, speed)
        angular = self._angular(body, plane, turn)
        wrench: Array = bias + np.array([MASS_KG * force_x, MASS_KG * force_y, MASS_KG * lift, 0.0, 0.0, 0.0])
        wrench[3:] += self._inertia * angular
        return wrench

    def _across(self, body: BodyMotion, speed: float, sway: Sway) -> tuple[float, float]:
        config = self._config
        ahead, left = body.ahead_left(*body.velocity_mps[:2])
        error = speed - ahead
        lasting = self._lasting_mps2 + config.speed_integral_hz2 * error * CONTROL_S
        self._lasting_mps2 = min(max(lasting, -_MOST_INTEGRAL_MPS2), _MOST_INTEGRAL_MPS2)
        if speed == 0.0:
            self._lasting_mps2 = 0.0
        stiff, damp = config.sway_gains
        push = config.speed_gain_hz * error + self._lasting_mps2 + stiff * sway.ahead_m
        shove = stiff * sway.left_m + damp * (sway.speed_mps - left) + sway.acceleration_mps2
        bound = _MOST_PUSH_MPS2
        return min(max(push, -bound), bound), min(max(shove, -bound), bound)

    def _lift(self, body: BodyMotion, plane: SupportPlane, speed: float) -> float:
        x, y, z = body.position_m
        stiff, damp = self._config.height_gains
        below = plane.height(x, y) + self._config.height_m - z
        rate = plane.slope_forward * speed - body.velocity_mps[2]
        return min(max(stiff * below + damp * rate, _SINK_MPS2), _LIFT_MPS2)

    def _angular(self, body: BodyMotion, plane: SupportPlane, turn: float) -> list[float]:
        lag = math.remainder(self._yaw_rad + turn * CONTROL_S - body.yaw_rad, 2 * math.pi)
        self._yaw_rad = body.yaw_rad + min(max(lag, -_MOST_YAW_LAG_RAD), _MOST_YAW_LAG_RAD)
        roll = _ROLL_SHARE * math.atan(plane.slope_left)
        pitch = -_PITCH_SHARE * math.atan(plane.slope_forward)
        (_, e01, e02), (e10, _, e12), (e20, e21, _) = (body.rotation.T @ upright(roll, pitch, self._yaw_rad)).tolist()
        up = body.rotation[2].tolist()
        rates = body.rates_radps
        (stiff, damp), (yaw_stiff, yaw_damp) = self._config.tilt_gains, self._config.yaw_gains
        return [
            stiff * 0.5 * (e21 - e12) + damp * (turn * up[0] - rates[0]),
            stiff * 0.5 * (e02 - e20) + damp * (turn * up[1] - rates[1]),
            yaw_stiff * 0.5 * (e10 - e01) + yaw_damp * (turn * up[2] - rates[2]),
        ]


def _standing_inertia() -> Float64[Array, "3"]:
    """Return the moments of inertia of the standing robot about the body's axes, each leg as a point by its hip."""
    x, y, z = (side * side for side in TRUNK_BOX_M)
    hip_x, hip_y = float(HIPS_M[0, 0]), float(HIPS_M[0, 1]) + HIP_OFFSET_M
    legs, down = 4 * LEG_KG, 0.1**2
    return np.array(
        [
            TRUNK_KG * (y + z) / 12 + legs * (hip_y**2 + down),
            TRUNK_KG * (x + z) / 12 + legs * (hip_x**2 + down),
            TRUNK_KG * (x + y) / 12 + legs * (hip_x**2 + hip_y**2),
        ]
    )
