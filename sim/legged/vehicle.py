"""The quadruped as a driver's vehicle in a world."""

import math

import numpy as np

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion
from navtool.sim.drive.drive import Drive, Measured
from navtool.sim.drive.vehicle import VehicleState
from navtool.sim.errors import SimError
from navtool.sim.legged.body import JOINT_NAMES, STEP_S
from navtool.sim.legged.controller_config import ControllerConfig
from navtool.sim.legged.gaits import GAITS, GaitName
from navtool.sim.legged.proprioception import (
    BATTERY_EVERY,
    IMU_EVERY,
    JOINTS_EVERY,
    ODOMETRY_EVERY,
    SensorConfig,
)
from navtool.sim.legged.robot import LeggedRobot, LeggedState
from navtool.sim.legged.track import LeggedTrack, track_of
from navtool.sim.legged.world_footing import WorldFooting
from navtool.sim.legged.world_obstacles import world_obstacles
from navtool.sim.world.place import World

HALF_WIDTH_M = 0.25
"""Half of the published width."""


class LeggedVehicle:
    """A quadruped in a world; it begins at the world's start and faces its goal (see `Vehicle`).

    Solid things stop it, what grows and lies there holds it, and it may fall.

    Args:
        world: The place.
        gait: How it walks after each reset.
        config: The controller's gains.
        sensors: The errors of its own sensors.

    Raises:
        SimError: Something solid stands at the world's start.
    """

    def __init__(
        self,
        world: World,
        gait: GaitName = GaitName.TROT,
        config: ControllerConfig | None = None,
        sensors: SensorConfig | None = None,
    ) -> None:
        (x, y), (goal_x, goal_y) = world.start_m, world.goal_m
        config = config or ControllerConfig()
        self._gait, self._sensors = gait, sensors
        start = (x, y, math.atan2(goal_y - y, goal_x - x))
        self._robot = LeggedRobot(WorldFooting(world), world_obstacles(world), gait, config, start)
        self.speed_limit_mps = GAITS[gait].top_speed_mps
        self.turn_limit_radps = config.top_turn_radps
        self.half_width_m = HALF_WIDTH_M

    def set_gait(self, gait: GaitName) -> None:
        """Walk on in another gait, which may have another speed limit, until the next reset."""
        self._robot.set_gait(gait)
        self.speed_limit_mps = GAITS[gait].top_speed_mps

    def reset(self, x_m: float, y_m: float, yaw_rad: float) -> VehicleState:
        """Stand at rest in the first gait, and forget what happened before.

        Raises:
            SimError: Something solid is in the way.
        """
        self.speed_limit_mps = GAITS[self._gait].top_speed_mps
        return self._state(self._robot.reset(x_m, y_m, yaw_rad))

    def step(self, speed_mps: float, turn_radps: float, duration_s: float, *, freed: bool = False) -> VehicleState:
        """The state after following a command for a while.

        Args:
            speed_mps: Forward speed; limited to the gait's.
            turn_radps: Turn, counter-clockwise; limited to the controller's.
            duration_s: A positive multiple of 4 ms.
            freed: Whether the operator frees it: what grows and lies there does not hold it meanwhile.

        Raises:
            SimError: The duration is no such multiple.
        """
        return self._state(self._robot.step(speed_mps, turn_radps, duration_s, freed=freed))

    def drive(self, seed: int) -> Drive:
        """All that happened since the reset; the seed decides the errors of the robot's own sensors.

        Raises:
            SimError: Nothing happened since the reset.
        """
        if self._robot.state().time_s == 0.0:
            raise SimError("a drive without a step", cure="step the robot before its drive is taken")
        track = track_of(self._robot, seed, self._sensors)
        return _drive_of(track, tuple((time_s, gait.value) for time_s, gait in self._robot.gaits))

    def _state(self, state: LeggedState) -> VehicleState:
        x, y, _ = state.position_m
        return VehicleState(
            time_s=state.time_s,
            x_m=x,
            y_m=y,
            yaw_rad=state.yaw_rad,
            speed_mps=state.forward_mps,
            turn_radps=state.rates_radps[2],
            touches=state.touches,
            held=state.held,
            fallen=state.fallen,
        )


def _drive_of(track: LeggedTrack, gaits: tuple[tuple[float, str], ...]) -> Drive:
    truth, measured = track.truth, track.measured
    to_world = transform_from_xyz_quaternion(truth.position_m, truth.quaternion)[:, :3, :3]
    return Drive(
        time_s=track.time_s,
        position_m=truth.position_m,
        quaternion=truth.quaternion,
        velocity_mps=np.einsum("nji,nj->ni", to_world, truth.velocity_mps),
        rates_radps=truth.rates_radps,
        command=truth.command,
        intervention=truth.freed,
        gait=gaits,
        imu=_stream(measured.imu, IMU_EVERY),
        joints=_stream(measured.joints, JOINTS_EVERY),
        joint_names=JOINT_NAMES,
        odometry=_stream(measured.odometry, ODOMETRY_EVERY),
        battery=_stream(measured.battery, BATTERY_EVERY, first=1),
        failures=track.failures,
    )


def _stream(values: Array, every: int, first: int = 0) -> Measured:
    """Return samples that are so many physics steps apart with their times."""
    return Measured(STEP_S * every * (first + np.arange(len(values), dtype=np.float64)), values)
