"""The quadruped on a ground: reset it, command it, and look at what becomes of it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from navtool.sim.errors import SimError
from navtool.sim.legged.body import (
    FOOT_RADIUS_M,
    HIP_OFFSET_M,
    HIPS_M,
    SIDES,
    STEP_S,
    TRUNK_PROBES,
    build,
    torque_limit,
)
from navtool.sim.legged.controller import Controller
from navtool.sim.legged.controller_config import CONTROL_S, ControllerConfig
from navtool.sim.legged.failures import FailureLimits
from navtool.sim.legged.footing import Footing
from navtool.sim.legged.gaits import GAITS, GaitName
from navtool.sim.legged.ground import Ground
from navtool.sim.legged.leg_kinematics import joints_for_foot
from navtool.sim.legged.obstacle import Obstacle
from navtool.sim.legged.samples import Recorder, Samples, Tick
from navtool.sim.legged.stepping import LegMode
from navtool.sim.legged.terrain import Terrain

FALL_TILT_RAD = 0.9
"""A robot that leans further than this has fallen."""
_STEPS = round(CONTROL_S / STEP_S)
_STAND_X_M, _STAND_M = -0.03, 0.47
"""Feet behind and below the hips: below the centre of mass, which the bent knees draw back."""
_HELD_S, _HELD_SHARE = 1.0, 0.5
"""A robot that makes less than this share of its way is held; time over which that is measured."""
_LIMP_NMS = 2.0
"""Damping of the joints once it has fallen and its motors are off."""


@dataclass(frozen=True, slots=True)
class LeggedState:
    """The robot now. World frame, SI units."""

    time_s: float
    """Since the reset."""
    position_m: tuple[float, float, float]
    """Position of the body's middle."""
    quaternion: tuple[float, float, float, float]
    """Attitude of the body: x, y, z, w."""
    velocity_mps: tuple[float, float, float]
    """Velocity of the body's middle, in the world's axes."""
    rates_radps: tuple[float, float, float]
    """In the body's axes."""
    foot_force_n: tuple[float, float, float, float]
    """How hard each foot presses."""
    touches: str | None
    """The name of an obstacle that the body or a leg pushes against."""
    held: bool
    """Whether what grows or lies there has taken most of the commanded speed away for about a second."""
    fallen: bool
    """Whether it leaned too far or lay on its trunk since the reset; its motors are off from then on."""

    @property
    def forward_mps(self) -> float:
        """Speed along the body's x axis."""
        x, y, z, w = self.quaternion
        vx, vy, vz = self.velocity_mps
        return (1 - 2 * (y * y + z * z)) * vx + 2 * (x * y + w * z) * vy + 2 * (x * z - w * y) * vz

    @property
    def yaw_rad(self) -> float:
        """Heading, -pi to pi."""
        x, y, z, w = self.quaternion
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class LeggedRobot:
    """One quadruped on one ground. The same calls after the same reset give the same motion, bit by bit.

    Args:
        footing: The ground.
        obstacles: Solid things that stand on it.
        gait: How it walks.
        config: The controller's gains.
        start: x and y in metres and yaw in radians where it begins.

    Attributes:
        obstacles: The solid things.
        terrain: The ground's shape and grip.
        model: MuJoCo's model of the robot.
        data: MuJoCo's state of it; what is written into it counts from the next step on.
        ground: What presses and holds it.

    Raises:
        SimError: The footing or an obstacle is out of range, or one stands where the robot begins.
    """

    def __init__(
        self,
        footing: Footing,
        obstacles: Sequence[Obstacle] = (),
        gait: GaitName = GaitName.TROT,
        config: ControllerConfig | None = None,
        start: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> None:
        self.obstacles = tuple(obstacles)
        self._limits = FailureLimits()
        self._gait = gait
        self._gaits = [(0.0, gait)]
        self.terrain = Terrain(footing)
        self.model = build(self.obstacles)
        self.data = mujoco.MjData(self.model)
        self._controller = Controller(self.model, GAITS[gait], config or ControllerConfig())
        self.ground = Ground(self.terrain, self.model)
        self._recorder = Recorder(self.data, _STEPS)
        self._trunk = self.model.body("trunk").id
        self._first_obstacle = self.model.geom("obstacle_0").id if self.obstacles else 0
        self.reset(*start)

    def set_gait(self, gait: GaitName) -> None:
        """Walk on in another gait, until the next reset."""
        self._controller.stepping.gait = GAITS[gait]
        now_s = self._recorder.count * STEP_S
        self._gaits = [(time_s, name) for time_s, name in self._gaits if time_s < now_s] + [(now_s, gait)]

    @property
    def gaits(self) -> tuple[tuple[float, GaitName], ...]:
        """From when on, in seconds since the reset, it walks in which gait."""
        return tuple(self._gaits)

    @property
    def felt_friction(self) -> float:
        """The coefficient of friction that the controller reckons with, as its feet have felt it since the reset."""
        return self._controller.grip.friction

    def reset(self, x_m: float = 0.0, y_m: float = 0.0, yaw_rad: float = 0.0) -> LeggedState:
        """Stand on the ground at a place, at rest, and forget what happened before.

        Raises:
            SimError: An obstacle is in the way.
        """
        data, model = self.data, self.model
        mujoco.mj_resetData(model, data)
        model.actuator_biasprm[:, 1:3] = 0.0
        data.qpos[:3] = x_m, y_m, 0.0
        data.qpos[3:7] = math.cos(yaw_rad / 2), 0.0, 0.0, math.sin(yaw_rad / 2)
        cosine, sine = math.cos(yaw_rad), math.sin(yaw_rad)
        ahead, left = HIPS_M[:, 0] + _STAND_X_M, HIPS_M[:, 1] + HIP_OFFSET_M * SIDES
        feet = np.stack([x_m + cosine * ahead - sine * left, y_m + sine * ahead + cosine * left], axis=-1)
        ground = self.terrain.height(feet)
        data.qpos[2] = ground.mean() + FOOT_RADIUS_M + _STAND_M
        for leg, side in enumerate(SIDES.tolist()):
            down = float(ground[leg]) + FOOT_RADIUS_M - float(data.qpos[2])
            data.qpos[7 + 3 * leg : 10 + 3 * leg] = joints_for_foot(_STAND_X_M, HIP_OFFSET_M * side, down, side)
        mujoco.mj_kinematics(model, data)
        self.ground.reset(data)
        mujoco.mj_forward(model, data)
        self._controller.reset(data, GAITS[self._gait])
        self._gaits = [(0.0, self._gait)]
        self._force_n = data.sensordata[6:10].copy()
        self._fallen = False
        self._held_n = self._asked_mps = self._went_mps = 0.0
        self._recorder = Recorder(data, _STEPS)
        touched = self._touched()
        self._recorder.begin(Tick((0.0, 0.0), (True,) * 4, touched))
        if touched >= 0:
            where = f"x = {x_m} m, y = {y_m} m"
            raise SimError(f"the robot cannot stand inside {self.obstacles[touched].name}", where=where)
        return self.state()

    def step(
        self, speed_mps: float, turn_radps: float, duration_s: float = CONTROL_S, *, freed: bool = False
    ) -> LeggedState:
        """Return the state after following a command for a while.

        Args:
            speed_mps: Forward speed; limited to the gait's.
            turn_radps: Turn, counter-clockwise; limited to the controller's.
            duration_s: A positive multiple of 4 ms.
            freed: Whether what grows and lies there does not hold it meanwhile.

        Raises:
            SimError: The duration is not, or the physics diverged.
        """
        ticks = round(duration_s / CONTROL_S)
        if ticks < 1 or abs(ticks * CONTROL_S - duration_s) > 1e-9:
            raise SimError(f"a step of {duration_s} s", cure=f"choose a positive multiple of {CONTROL_S} s")
        for _ in range(ticks):
            self._tick(speed_mps, turn_radps, freed=freed)
        return self.state()

    def state(self) -> LeggedState:
        """Return the state now."""
        x, y, z, qw, qx, qy, qz = self.data.qpos[:7].tolist()
        vx, vy, vz, roll, pitch, yaw = self.data.qvel[:6].tolist()
        a, b, c, d = self._force_n.tolist()
        touched = self._touched()
        return LeggedState(
            time_s=self._recorder.count * STEP_S,
            position_m=(x, y, z),
            quaternion=(qx, qy, qz, qw),
            velocity_mps=(vx, vy, vz),
            rates_radps=(roll, pitch, yaw),
            foot_force_n=(a, b, c, d),
            touches=self.obstacles[touched].name if touched >= 0 else None,
            held=self._is_held(),
            fallen=self._fallen,
        )

    def samples(self) -> Samples:
        """Return what happened since the last reset, one entry a physics step."""
        return self._recorder.samples()

    def _is_held(self) -> bool:
        limits = self._limits
        slow = self._went_mps < _HELD_SHARE * self._asked_mps
        return slow and self._asked_mps > limits.least_command_mps and self._held_n > limits.held_n

    def _tick(self, speed_mps: float, turn_radps: float, *, freed: bool) -> None:
        """Let the controller decide once and the physics follow."""
        data, model, recorder = self.data, self.model, self._recorder
        self.ground.lay(data)
        mujoco.mj_step1(model, data)
        drag = self.ground.hold(data, freed=freed)
        self._drive(speed_mps, turn_radps)
        mujoco.mj_step2(model, data)
        recorder.step()
        for _ in range(_STEPS - 1):
            mujoco.mj_step(model, data)
            recorder.step()
        if data.time < (recorder.count - 0.5) * STEP_S:
            where = f"{recorder.count * STEP_S:.3f} s after the reset"
            raise SimError("the physics diverged", where=where, cure="report the footing: no ground should do this")
        self._force_n = data.sensordata[6:10].copy()
        upright = float(data.xmat[self._trunk, 8])
        down = self.ground.reaches(TRUNK_PROBES)
        self._fallen = self._fallen or down or upright < math.cos(FALL_TILT_RAD)
        stepping = self._controller.stepping
        standing = tuple(mode is LegMode.STANCE for mode in stepping.modes)
        self._follow(speed_mps, drag)
        command = (speed_mps, turn_radps)
        recorder.tick(Tick(command, standing, self._touched(), freed, drag, stepping.stumbles, down, self._fallen))

    def _follow(self, speed_mps: float, drag_n: float) -> None:
        """Let the means over the last moments follow."""
        share = CONTROL_S / _HELD_S
        went = math.hypot(*self.data.qvel[:2].tolist())
        self._held_n += share * (drag_n - self._held_n)
        self._asked_mps += share * (abs(speed_mps) - self._asked_mps)
        self._went_mps += share * (went - self._went_mps)

    def _drive(self, speed_mps: float, turn_radps: float) -> None:
        data, model = self.data, self.model
        if self._fallen:
            data.ctrl[:] = 0.0
            model.actuator_biasprm[:, 1], model.actuator_biasprm[:, 2] = 0.0, -_LIMP_NMS
            return
        joints = self._controller.update(data, self._force_n, speed_mps, turn_radps)
        limit = torque_limit(data.qpos[7:19])
        model.jnt_actfrcrange[1:, 0], model.jnt_actfrcrange[1:, 1] = -limit, limit
        data.ctrl[:] = joints.torque_nm + joints.kp * joints.position_rad + joints.kd * joints.velocity_radps
        model.actuator_biasprm[:, 1], model.actuator_biasprm[:, 2] = -joints.kp, -joints.kd

    def _touched(self) -> int:
        """Return the number of the first obstacle in contact, -1 for none."""
        if not self.obstacles or not self.data.ncon:
            return -1
        geoms = self.data.contact.geom.reshape(-1)
        numbers = geoms[(geoms >= self._first_obstacle) & (geoms < self._first_obstacle + len(self.obstacles))]
        return int(numbers.min()) - self._first_obstacle if numbers.size else -1
