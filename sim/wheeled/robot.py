"""The wheeled robot in a place: reset it, command it, and see what has become of it."""

import math

import numpy as np

from navtool.sim.drive.drive import Drive
from navtool.sim.drive.vehicle import VehicleState
from navtool.sim.errors import SimError
from navtool.sim.wheeled.config import GRAVITY_MPS2, STEP_S, WHEELS, WheeledConfig
from navtool.sim.wheeled.failures import FailureLimits, find_failures
from navtool.sim.wheeled.footing import Footing
from navtool.sim.wheeled.outlines import Outlines
from navtool.sim.wheeled.proprioception import SensorConfig, measure
from navtool.sim.wheeled.rolling import Rolling, Under
from navtool.sim.wheeled.samples import Samples
from navtool.sim.wheeled.tyres import Tyres
from navtool.sim.world.place import World

_NEAR_M = 0.03
"""Beyond what it goes in a step."""
_SLOP_M = 1e-3
"""Footprint and outlines keep this distance, so that rounding never makes them overlap."""
_SIDEWAYS = 3.0
"""Tyres creep sideways under a steady push: a contact moves the robot sideways this many times as easily as it would
were it free, but only while it pushes. Chosen: without it a robot beside a wall could never turn away from it."""
_LEVEL_M = 0.1
"""Height of the centre of mass above the bumpers: a blow makes the robot nod."""
_NOD_M2 = 0.05
"""Inertia about the axles over mass."""


class WheeledRobot:
    """A skid-steered robot. The same calls after the same reset give the same drive, bit by bit.

    It is a `Vehicle`: fast, because a step is a handful of look-ups and no solver.

    Args:
        world: Where it drives.
        config: Its body and drives.
        sensors: Errors of its own sensors.
        limits: From where on something counts as a failure.
    """

    def __init__(
        self,
        world: World,
        config: WheeledConfig | None = None,
        sensors: SensorConfig | None = None,
        limits: FailureLimits | None = None,
    ) -> None:
        self.config = config or WheeledConfig()
        self.speed_limit_mps = self.config.speed_limit_mps
        self.turn_limit_radps = self.config.turn_limit_radps
        self.half_width_m = self.config.half_width_m
        self._items = world.obstacles.items
        self._sensors, self._limits = sensors or SensorConfig(), limits or FailureLimits()
        self._footing = Footing(world)
        self._outlines = Outlines(
            world.obstacles, self.config.half_length_m, self.half_width_m, world.ground.half_side_m
        )
        self._rolling, self._tyres = Rolling(self.config), Tyres(self.config)
        ahead, aside = 0.5 * self.config.wheel_base_m, 0.5 * self.config.track_m
        self._wheels = ((ahead, aside), (ahead, -aside), (-ahead, aside), (-ahead, -aside))
        self._rows: list[tuple[float, ...]] = []

    def reset(self, x_m: float, y_m: float, yaw_rad: float) -> VehicleState:
        """Stand at rest, and forget what happened before.

        Raises:
            SimError: Something solid stands there, or the ground is too steep to stand on.
        """
        x_m, y_m, yaw_rad = float(x_m), float(y_m), float(yaw_rad)
        cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
        inside = self._outlines.contacts(x_m, y_m, cos, sin, _SLOP_M)
        if inside:
            what = f"the robot cannot stand inside or against a {self._items[inside[0].item].kind}"
            raise SimError(what, where=f"x = {x_m:.2f} m, y = {y_m:.2f} m", cure="let it start elsewhere")
        self._x, self._y, self._yaw = x_m, y_m, yaw_rad
        self._rolling.reset()
        height, roll, pitch, _ = self._ground()
        self._tyres.reset(height, roll, pitch)
        self._fallen = max(abs(roll), abs(pitch)) > self.config.fall_tilt_rad
        if self._fallen:
            where = f"x = {x_m:.2f} m, y = {y_m:.2f} m"
            raise SimError("the ground is too steep to stand on", where=where, cure="let it start elsewhere")
        self._touched, self._nod, self._aside_mps = -1, 0.0, 0.0
        self._rows = []
        self._record(0.0, 0.0, freed=False)
        return self._state()

    def step(self, speed_mps: float, turn_radps: float, duration_s: float, *, freed: bool = False) -> VehicleState:
        """The state after following a command for a while.

        Args:
            speed_mps: Forward speed; limited to the robot's.
            turn_radps: Turn, counter-clockwise; limited to the robot's.
            duration_s: A positive multiple of 0.02 s.
            freed: Whether the operator frees it: what is soft does not hold it meanwhile.

        Raises:
            SimError: It was never reset, or the duration is none.
        """
        steps = round(duration_s / STEP_S)
        if steps < 2 or steps % 2 or abs(steps * STEP_S - duration_s) > 1e-6:
            raise SimError(f"a step of {duration_s} s", cure="choose a positive multiple of 0.02 s")
        if not self._rows:
            raise SimError("the robot stands nowhere yet", cure="reset it first")
        # plain numbers: a step with NumPy's takes twice as long
        speed = max(-self.speed_limit_mps, min(self.speed_limit_mps, float(speed_mps)))
        turn = max(-self.turn_limit_radps, min(self.turn_limit_radps, float(turn_radps)))
        for _ in range(steps):
            self._advance(speed, turn, freed=freed)
            self._record(speed, turn, freed=freed)
        return self._state()

    def samples(self) -> Samples:
        """What it did since the reset."""
        return Samples(np.array(self._rows))

    def drive(self, seed: int) -> Drive:
        """All that happened since the reset; the seed decides the errors of the robot's own sensors.

        Raises:
            SimError: It has not moved on since the reset.
        """
        if len(self._rows) < 3:
            raise SimError("no drive has happened since the reset", cure="step it first")
        samples = self.samples()
        quaternion = samples.quaternion()
        measured = measure(samples, seed, self.config, self._sensors)
        return Drive(
            time_s=samples.time_s,
            position_m=samples.position_m(),
            quaternion=quaternion,
            velocity_mps=samples.body_velocity_mps(),
            rates_radps=samples.rates_radps(),
            command=samples.command.copy(),
            intervention=samples.freed,
            imu=measured.imu,
            joints=measured.joints,
            joint_names=WHEELS,
            odometry=measured.odometry,
            battery=measured.battery,
            failures=find_failures(samples, self._items, self._limits),
        )

    def _ground(self) -> tuple[float, float, float, Under]:
        """Height, roll and pitch of the plane through the wheels' footprints, and what is under them."""
        cos, sin = math.cos(self._yaw), math.sin(self._yaw)
        heights, friction, rolling, rise, drag, plants = [], [], [], 0.0, 0.0, 0.0
        for along, across in self._wheels:
            height, rise_x, rise_y, grip, rolls, sticks, grown, surface = self._footing.at(
                self._x + cos * along - sin * across, self._y + sin * along + cos * across
            )
            heights.append(height)
            friction.append(grip)
            rolling.append(rolls)
            rise += 0.25 * (cos * rise_x + sin * rise_y)
            drag += 0.25 * (sticks + grown)
            plants += 0.25 * grown
            if len(rolling) == 1 or rolls >= max(rolling):
                self._surface = surface
        front_left, front_right, rear_left, rear_right = heights
        c = self.config
        roll = math.atan2(0.5 * (front_left + rear_left - front_right - rear_right), c.track_m)
        pitch = math.atan2(0.5 * (rear_left + rear_right - front_left - front_right), c.wheel_base_m)
        half = 0.5 * c.mass_kg * GRAVITY_MPS2 * self._tyres.load / math.hypot(1.0, rise)
        shift = max(-1.0, min(1.0, 2.0 * c.centre_m * math.tan(roll) / c.track_m))
        under = Under(
            (half * (1.0 - shift), half * (1.0 + shift)),
            (0.5 * (friction[0] + friction[2]), 0.5 * (friction[1] + friction[3])),
            (0.5 * (rolling[0] + rolling[2]), 0.5 * (rolling[1] + rolling[3])),
            rise,
            drag,
            plants,
        )
        return 0.25 * sum(heights), roll, pitch, under

    def _advance(self, speed_mps: float, turn_radps: float, *, freed: bool) -> None:
        if self._fallen:
            return
        height, roll, pitch, under = self._ground()
        tyres, rolling = self._tyres, self._rolling
        tyres.step(height, roll, pitch, nod_radps=self._nod)
        self._fallen = max(abs(tyres.value[1]), abs(tyres.value[2])) > self.config.fall_tilt_rad
        if self._fallen:
            rolling.reset()
            self._touched, self._nod, self._aside_mps = -1, 0.0, 0.0
            tyres.rate[:] = 0.0, 0.0, 0.0
            return
        rolling.step(speed_mps, turn_radps, under, freed=freed)
        self._meet()
        middle = self._yaw + 0.5 * rolling.turn_radps * STEP_S
        way = rolling.speed_mps * STEP_S / math.hypot(1.0, under.uphill)
        before = self._x, self._y, self._yaw
        self._x += way * math.cos(middle) - self._aside_mps * STEP_S * math.sin(middle)
        self._y += way * math.sin(middle) + self._aside_mps * STEP_S * math.cos(middle)
        self._yaw += rolling.turn_radps * STEP_S
        if self._outlines.contacts(self._x, self._y, math.cos(self._yaw), math.sin(self._yaw), 0.0):
            self._x, self._y, self._yaw = before
            rolling.speed_mps = rolling.turn_radps = self._aside_mps = 0.0

    def _meet(self) -> None:
        """Take from speed and turn what would carry the footprint into something solid: a blow without rebound."""
        rolling, c = self._rolling, self.config
        near = self._outlines.contacts(self._x, self._y, math.cos(self._yaw), math.sin(self._yaw), _NEAR_M)
        self._touched, before, aside, light = -1, rolling.speed_mps, 0.0, _SIDEWAYS / c.mass_kg
        for _ in range(4 if near else 0):
            for contact in near:
                lever = contact.x_m * contact.normal_y - contact.y_m * contact.normal_x
                opening = contact.normal_x * rolling.speed_mps + contact.normal_y * aside + lever * rolling.turn_radps
                apart = contact.gap_m - _SLOP_M
                lack = -apart * (1.0 if apart > 0 else 0.2) / STEP_S - opening
                if lack <= 0.0:
                    continue
                per_n = contact.normal_x**2 / c.mass_kg + contact.normal_y**2 * light + lever**2 / c.yaw_inertia_kgm2
                rolling.speed_mps += lack * contact.normal_x / c.mass_kg / per_n
                aside += lack * contact.normal_y * light / per_n
                rolling.turn_radps += lack * lever / c.yaw_inertia_kgm2 / per_n
                self._touched = contact.item
        self._aside_mps = aside
        self._nod = (rolling.speed_mps - before) * _LEVEL_M / _NOD_M2

    def _record(self, speed_mps: float, turn_radps: float, *, freed: bool) -> None:
        rolling, tyres = self._rolling, self._tyres
        height, roll, pitch = tyres.value
        place = self._x, self._y, height, roll, pitch, self._yaw
        moves = rolling.speed_mps, rolling.turn_radps, *tyres.rate, *rolling.wheel_mps
        drives = *rolling.force_n, rolling.power_w, rolling.lost_w, speed_mps, turn_radps, freed
        self._rows.append(
            (
                *place,
                *moves,
                *drives,
                self._touched,
                rolling.held,
                rolling.spins,
                self._surface,
                self._fallen,
                self._aside_mps,
            )
        )

    def _state(self) -> VehicleState:
        return VehicleState(
            time_s=STEP_S * (len(self._rows) - 1),
            x_m=self._x,
            y_m=self._y,
            yaw_rad=math.atan2(math.sin(self._yaw), math.cos(self._yaw)),
            speed_mps=self._rolling.speed_mps,
            turn_radps=self._rolling.turn_radps,
            touches=None if self._touched < 0 else self._items[self._touched].kind,
            held=self._rolling.held,
            fallen=self._fallen,
        )
