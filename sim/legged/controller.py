"""Walking: turns a commanded speed and turn into joint torques, from what the robot feels alone."""

import math
from typing import NamedTuple

import mujoco
import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.legged.balance import Balance, Sway
from navtool.sim.legged.body import FOOT_RADIUS_M, HIP_OFFSET_M, HIPS_M, JOINT_DAMPING_NMS, LEGS, SIDES
from navtool.sim.legged.body_motion import BodyMotion, body_motion
from navtool.sim.legged.controller_config import CONTROL_S, ControllerConfig
from navtool.sim.legged.felt_grip import FeltGrip
from navtool.sim.legged.gaits import Gait
from navtool.sim.legged.leg_kinematics import joints_for_foot
from navtool.sim.legged.stance import ground_forces
from navtool.sim.legged.stepping import LegMode, Stepping
from navtool.sim.legged.support_margin import inward
from navtool.sim.legged.support_plane import SupportPlane

_KP, _SWING_KD = 220.0, 7.0
_STANCE_KD, _LOST_KD = 0.4, 7.0
"""Damping of a leg that carries, and of one that lost the ground it carried on: it goes after it, but not wildly."""
_TOP_RATE_RADPS, _TOP_RADPS2 = 12.0, 200.0
_PLANE_LAG_S = 0.25
_SOON_S = 0.1
"""The body is kept inside its feet where it will be after this time: the middle of a step."""
_PRESS_M = 0.005
"""A foot is aimed this far below the expected ground, to meet it in time."""
_HIPS = HIPS_M.tolist()
_NEUTRAL_M = [(x, y + HIP_OFFSET_M * side) for (x, y, _), side in zip(_HIPS, SIDES.tolist(), strict=True)]
"""Below these points of the body the feet stand when the robot stands."""


class JointCommand(NamedTuple):
    """What the motors do until the next decision: torque + kp (position - q) + kd (velocity - dq)."""

    torque_nm: Float64[Array, "12"]
    position_rad: Float64[Array, "12"]
    velocity_radps: Float64[Array, "12"]
    kp: Float64[Array, "12"]
    kd: Float64[Array, "12"]


class Controller:
    """Walks by a phase table, foot placement by velocity error, and shared ground forces for the body's balance.

    It knows the body's pose and velocity (a perfect state estimate), joint angles and rates, and how hard each foot
    presses. It does not know the terrain: where the ground is it learns by stepping on it.

    Args:
        model: The robot's model.
        gait: The order of steps.
        config: Gains.
    """

    def __init__(self, model: mujoco.MjModel, gait: Gait, config: ControllerConfig) -> None:
        self._config = config
        self._model = model
        self._sites = [model.site(f"{leg}_foot").id for leg in LEGS]
        self._trunk = model.body("trunk").id
        self._jacobian = np.zeros((12, model.nv))
        self._rows = [self._jacobian[3 * leg : 3 * leg + 3] for leg in range(4)]
        self._acceleration, self._legs = np.zeros(model.nv), np.zeros(model.nv)
        self.stepping = Stepping(gait, config)

    def reset(self, data: mujoco.MjData, gait: Gait) -> None:
        """Stand, with all feet on the ground, ready to walk in a gait."""
        body = body_motion(data, self._trunk)
        self.stepping = Stepping(gait, self._config)
        self.command = (0.0, 0.0)
        """Speed and turn that are kept now."""
        self._balance = Balance(self._config, body.yaw_rad)
        self._stood_m = data.site_xpos[self._sites].tolist()
        for foot in self._stood_m:
            foot[2] -= FOOT_RADIUS_M
        self._angles, self._rates = [0.0] * 12, [0.0] * 12
        self._in_air = [False] * 4
        self.grip = FeltGrip()
        self._asked = [0.0] * 4
        self._plane = SupportPlane(_PLANE_LAG_S)
        self._plane.follow(self._stood_m, (body.cosine, body.sine), math.inf)

    def update(
        self, data: mujoco.MjData, force_n: Float64[Array, "4"], speed_mps: float, turn_radps: float
    ) -> JointCommand:
        """Return what the motors do for the next `CONTROL_S` seconds.

        Args:
            data: The robot's state, with kinematics and bias forces up to date.
            force_n: How hard each foot presses.
            speed_mps: Commanded speed; limited to the gait's.
            turn_radps: Commanded turn; limited.
        """
        body = body_motion(data, self._trunk)
        feet = data.site_xpos[self._sites].tolist()
        touching = [force > self._config.touch_n for force in force_n.tolist()]
        self._follow(speed_mps, turn_radps)
        self.stepping.advance(feet, touching, wanted=self._wants_to_walk(body))
        for leg, mode in enumerate(self.stepping.modes):
            if touching[leg] and mode is LegMode.STANCE:
                x, y, z = feet[leg]
                self._stood_m[leg] = [x, y, z - FOOT_RADIUS_M]
        self._plane.follow(self._stood_m, (body.cosine, body.sine), CONTROL_S)
        for leg, site in enumerate(self._sites):
            mujoco.mj_jacSite(self._model, data, self._rows[leg], None, site)
        self._feel(data, force_n)
        command, self._acceleration[6:] = self._command(body, touching)
        wrench = self._balance.wrench(body, data.qfrc_bias[:6], self._plane, self.command, self._sway(body))
        mujoco.mj_mulM(self._model, data, self._legs, self._acceleration)
        trust = self.stepping.trust()
        forces = ground_forces(self._jacobian, wrench + self._legs[:6], trust, self.grip.friction)
        self._asked = [math.hypot(x, y) / z if z > 0.0 else 0.0 for x, y, z in forces.reshape(4, 3).tolist()]
        torque = data.qfrc_bias[6:18] + JOINT_DAMPING_NMS * data.qvel[6:18] + self._legs[6:]
        return command._replace(torque_nm=torque - forces @ self._jacobian[:, 6:18])

    def _feel(self, data: mujoco.MjData, force_n: Float64[Array, "4"]) -> None:
        """Learn from feet that slide although they carry."""
        velocity = (self._jacobian @ data.qvel).reshape(4, 3)
        speed = [math.hypot(x, y) for x, y, _ in velocity.tolist()]
        standing = [mode is LegMode.STANCE for mode in self.stepping.modes]
        self.grip.feel(speed, force_n.tolist(), self._asked, standing)

    def _follow(self, speed_mps: float, turn_radps: float) -> None:
        """Bring the kept command nearer to the given one."""
        config, (speed, turn) = self._config, self.command
        top = self.stepping.gait.top_speed_mps
        quicker = config.acceleration_mps2 * CONTROL_S
        tighter = config.turn_acceleration_radps2 * CONTROL_S
        wanted_speed = min(max(speed_mps, -top), top)
        wanted_turn = min(max(turn_radps, -config.top_turn_radps), config.top_turn_radps)
        self.command = (
            speed + min(max(wanted_speed - speed, -quicker), quicker),
            turn + min(max(wanted_turn - turn, -tighter), tighter),
        )

    def _wants_to_walk(self, body: BodyMotion) -> bool:
        """Whether there is a command, or it has to step to keep its balance."""
        speed, turn = self.command
        return abs(speed) > 0.01 or abs(turn) > 0.01 or math.hypot(*body.velocity_mps[:2]) > self._config.push_mps

    def _sway(self, body: BodyMotion) -> Sway:
        """Return how the body moves over its feet.

        To their middle while it stands; to the side as it walks, and, where the gait asks for a margin, away from the
        edge that it would tip over.
        """
        x = 0.25 * sum(foot[0] for foot in self._stood_m) - body.centre_m[0]
        y = 0.25 * sum(foot[1] for foot in self._stood_m) - body.centre_m[1]
        ahead, left = body.ahead_left(x, y)
        if not self.stepping.walking:
            return Sway(ahead, left, 0.0, 0.0)
        gait, leg = self.stepping.gait, self.stepping.stepping_leg()
        place, speed, acceleration = gait.sway(self.stepping.phase)
        if gait.margin_m == 0.0 or leg is None:
            return Sway(0.0, left + place, speed, acceleration)
        soon = [at + _SOON_S * rate for at, rate in zip(body.centre_m, body.velocity_mps, strict=True)]
        ahead, inner = body.ahead_left(*inward(self._stood_m, leg, (soon[0], soon[1]), gait.margin_m))
        return Sway(ahead, left + place + inner, speed, acceleration)

    def _command(self, body: BodyMotion, touching: list[bool]) -> tuple[JointCommand, Float64[Array, "12"]]:
        """Return what legs in the air do, and the joints' accelerations that it takes."""
        position, velocity, kp, kd = [0.0] * 12, [0.0] * 12, [0.0] * 12, [_STANCE_KD] * 12
        acceleration = [0.0] * 12
        axes = body.rotation.T.tolist()
        for leg in range(4):
            fresh, self._in_air[leg] = not self._in_air[leg], self.stepping.modes[leg] is not LegMode.STANCE
            if not self._in_air[leg]:
                if not touching[leg]:
                    kd[3 * leg : 3 * leg + 3] = [_LOST_KD] * 3
                continue
            place = self._foot_place(body, leg)
            dx, dy, dz = (to - at for to, at in zip(place, body.position_m, strict=True))
            at = [row[0] * dx + row[1] * dy + row[2] * dz - hip for row, hip in zip(axes, _HIPS[leg], strict=True)]
            for joint, angle in enumerate(joints_for_foot(at[0], at[1], at[2], float(SIDES[leg])), 3 * leg):
                rate = 0.0 if fresh else _within((angle - self._angles[joint]) / CONTROL_S, _TOP_RATE_RADPS)
                if not fresh:
                    acceleration[joint] = _within((rate - self._rates[joint]) / CONTROL_S, _TOP_RADPS2)
                position[joint], velocity[joint], kp[joint], kd[joint] = angle, rate, _KP, _SWING_KD
                self._angles[joint], self._rates[joint] = angle, rate
        motors = (np.array(values) for values in (position, velocity, kp, kd))
        return JointCommand(np.zeros(12), *motors), np.array(acceleration)

    def _foot_place(self, body: BodyMotion, leg: int) -> tuple[float, float, float]:
        """Return where the centre of a foot in the air shall be now.

        It comes down where it will be below its hip in the middle of its stance, and further ahead the more the body
        is too fast: that is what slows it down.
        """
        stepping, (speed, turn) = self.stepping, self.command
        gait, share = stepping.gait, stepping.share(leg)
        if share is None:
            return stepping.reach[leg]
        remaining = (1.0 - share) * gait.swing_s
        yaw = body.yaw_rad + turn * (remaining + 0.5 * gait.stance_s)
        cosine, sine = math.cos(yaw), math.sin(yaw)
        ahead, left = _NEUTRAL_M[leg]
        wanted_x, wanted_y = body.from_heading(speed, 0.0)
        vx, vy, _ = body.velocity_mps
        half, gain = 0.5 * gait.stance_s, self._config.placement_gain_s
        x = body.centre_m[0] + vx * remaining + cosine * ahead - sine * left + half * wanted_x + gain * (vx - wanted_x)
        y = body.centre_m[1] + vy * remaining + sine * ahead + cosine * left + half * wanted_y + gain * (vy - wanted_y)
        z = self._plane.height(x, y) + FOOT_RADIUS_M - _PRESS_M
        return stepping.swings[leg].place(share, (x, y, z))


def _within(value: float, bound: float) -> float:
    return min(max(value, -bound), bound)
