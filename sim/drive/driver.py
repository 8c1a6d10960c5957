"""A randomised driver: goes about a place, now and then carelessly, and is freed by an operator when stuck.

GrASPE (V-B) records its data with a randomised planner, so that both what succeeds and what fails is in it.
"""

import math
from enum import Enum, auto

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.drive.command import DECIDE_S, Command
from navtool.sim.drive.config import DriveConfig
from navtool.sim.drive.script import towards
from navtool.sim.drive.surroundings import Surroundings
from navtool.sim.drive.vehicle import Vehicle, VehicleState

_MARGIN_M = 0.35
"""A careful leg keeps this far from what is solid, beside half the robot's width."""
_LOOKS_M = 1.0
"""So far ahead a careful driver looks before it goes on."""
_LEG_S = 12.0
"""No leg takes longer."""
_NO_HEADWAY, _NO_HEADWAY_S = 0.2, 0.8
"""A driver notices that it is stuck when it has made less than this share of its way for so long."""
_BACK_MPS = 0.4
_TARGETS, _POINTS = 24, 16


class Mode(Enum):
    """What the driver is doing."""

    go = auto()
    wander = auto()
    push = auto()
    """Still asking for the same, against what stops the robot."""
    back_off = auto()
    rescue = auto()
    """The operator frees the robot, which backs out."""


class RandomDriver:
    """Decides every ``DECIDE_S``; all chance comes from one generator. Drives any vehicle in any place.

    Args:
        vehicle: The robot that is driven; only its limits and size are used.
        surroundings: What the driver knows of the place.
        config: How fast and how careless.
        rng: Source of all decisions.
    """

    def __init__(
        self, vehicle: Vehicle, surroundings: Surroundings, config: DriveConfig, rng: np.random.Generator
    ) -> None:
        self.mode = Mode.go
        self._room, self._config, self._rng = surroundings, config, rng
        self._mischief = 0.0 if float(rng.random()) < config.careful else config.mischief
        self._half_width_m = vehicle.half_width_m
        self._fastest = min(config.speed_mps[1], vehicle.speed_limit_mps)
        self._slowest = min(config.speed_mps[0], self._fastest)
        self._turn = min(config.turn_radps, vehicle.turn_limit_radps)
        self._deadline_s, self._careless = 0.0, False
        self._target = (0.0, 0.0)
        self._last = Command(0.0, 0.0)
        self._stopped_s, self._scraped_s, self._from = 0.0, 0.0, (0.0, 0.0)

    def command(self, state: VehicleState) -> Command:
        """What is asked for now."""
        over = state.time_s >= self._deadline_s - 1e-9
        match self.mode:
            case Mode.go | Mode.wander if self._notices(state):
                self._enter(Mode.push, state, 0.8, 2.5)
            case Mode.go | Mode.wander if over or self._arrived(state) or self._sees_an_end(state):
                self._choose_leg(state)
            case Mode.push if over:
                self._back_off(state)
            case Mode.back_off if over and self._moved(state) < 0.12:
                self._enter(Mode.rescue, state, 2.0, 3.0)
                self._last = self._last._replace(freed=True)
            case Mode.rescue if over and self._moved(state) < 0.12:
                # neither way is free: turn, and try the other one
                self._enter(Mode.rescue, state, 1.5, 2.5)
                turn = float(self._rng.choice([-1.0, 1.0])) * self._turn
                self._last = Command(-self._last.speed_mps, turn, freed=True)
            case Mode.back_off | Mode.rescue if over:
                self._choose_leg(state, careful=True)
        if self.mode is Mode.go:
            self._last = towards(state, self._target, self._speed, self._turn)
        return self._last

    def _enter(self, mode: Mode, state: VehicleState, shortest_s: float, longest_s: float) -> None:
        self.mode = mode
        self._deadline_s = state.time_s + float(self._rng.uniform(shortest_s, longest_s))
        self._from, self._stopped_s, self._scraped_s = (state.x_m, state.y_m), 0.0, 0.0

    def _moved(self, state: VehicleState) -> float:
        return math.hypot(state.x_m - self._from[0], state.y_m - self._from[1])

    def _arrived(self, state: VehicleState) -> bool:
        away = math.hypot(self._target[0] - state.x_m, self._target[1] - state.y_m)
        return self.mode is Mode.go and away < 0.4

    def _notices(self, state: VehicleState) -> bool:
        """Whether it has asked for motion and seen none for a while; a blow is noticed at once."""
        last = self._last
        goes = abs(state.speed_mps) > _NO_HEADWAY * abs(last.speed_mps) and abs(last.speed_mps) > 0.05
        turns = abs(state.turn_radps) > _NO_HEADWAY * abs(last.turn_radps) and abs(last.turn_radps) > 0.1
        asks = abs(last.speed_mps) > 0.05 or abs(last.turn_radps) > 0.1
        self._stopped_s = self._stopped_s + DECIDE_S if asks and not goes and not turns else 0.0
        self._scraped_s = self._scraped_s + DECIDE_S if state.touches is not None else 0.0
        stopped = state.touches is not None and abs(state.speed_mps) < 0.1
        return stopped or self._stopped_s >= _NO_HEADWAY_S or self._scraped_s >= _NO_HEADWAY_S

    def _back_off(self, state: VehicleState) -> None:
        """Go back the other way; what holds the robot softly is left to the operator."""
        mode = Mode.rescue if state.held else Mode.back_off
        self._enter(mode, state, 1.5, 2.8)
        back = -math.copysign(_BACK_MPS, self._last.speed_mps if abs(self._last.speed_mps) > 0.05 else 1.0)
        turn = float(self._rng.uniform(-0.4, 0.4)) * self._turn
        self._last = Command(back, turn, freed=mode is Mode.rescue)

    def _sees_an_end(self, state: VehicleState) -> bool:
        """Whether a careful driver is about to run into something solid, or to leave the place."""
        ahead = math.copysign(1.0, self._last.speed_mps) * np.linspace(0.2, _LOOKS_M, 5)
        x = state.x_m + ahead * math.cos(state.yaw_rad)
        y = state.y_m + ahead * math.sin(state.yaw_rad)
        if self.mode is Mode.wander and not self._room.inside(x[-1:], y[-1:], 0.0).all():
            return bool(self._room.inside(x[:1], y[:1], 0.0).all())
        if self._careless or abs(self._last.speed_mps) < 0.1:
            return False
        return bool(self._room.solid_m(x, y).min() < self._half_width_m)

    def _choose_leg(self, state: VehicleState, *, careful: bool = False) -> None:
        """A thing to be careless about, a random speed and turn for a while, or a point that can be reached."""
        rng, config = self._rng, self._config
        self._speed = float(rng.uniform(self._slowest, self._fastest))
        self._stopped_s, self._from = 0.0, (state.x_m, state.y_m)
        self._careless = float(rng.random()) < self._mischief and not careful
        if self._careless:
            target = self._thing_ahead(state)
            if target is not None:
                self.mode, self._target, self._deadline_s = Mode.go, target, state.time_s + _LEG_S
                return
        self._careless = False
        if not careful and float(rng.random()) < config.wander:
            self.mode = Mode.wander
            self._deadline_s = state.time_s + float(rng.uniform(1.0, 4.0))
            self._last = Command(self._speed, float(rng.uniform(-self._turn, self._turn)))
            if not self._sees_an_end(state):
                return
        self.mode, self._deadline_s = Mode.go, state.time_s + _LEG_S
        self._target = self._free_target(np.array([state.x_m, state.y_m]), state.yaw_rad)

    def _thing_ahead(self, state: VehicleState) -> tuple[float, float] | None:
        """A point beyond a thing not far ahead, on the line through it: the way there leads into it."""
        things = self._room.things
        if not things:
            return None
        x, y = np.array([(thing.x_m - state.x_m, thing.y_m - state.y_m) for thing in things]).T
        away = np.hypot(x, y)
        ahead = np.cos(np.arctan2(y, x) - state.yaw_rad)
        near = np.flatnonzero((away > 1.0) & (away < 7.0) & (ahead > 0.3))
        if not near.size:
            return None
        chosen = int(self._rng.choice(near))
        beyond = 1.0 + 2.0 / float(away[chosen])
        half_x, half_y = self._room.half_extent_m
        to_x, to_y = state.x_m + beyond * float(x[chosen]), state.y_m + beyond * float(y[chosen])
        return max(-half_x, min(half_x, to_x)), max(-half_y, min(half_y, to_y))

    def _free_target(self, here: Float64[Array, "2"], yaw_rad: float) -> tuple[float, float]:
        """The target with the widest way among some random ones, those ahead and without tall grass first."""
        turn = self._rng.normal(0.0, 1.0, _TARGETS)
        length = self._rng.uniform(1.5, 7.0, _TARGETS)
        half = np.array(self._room.half_extent_m)[:, None] - _MARGIN_M - self._half_width_m
        way = np.stack([np.cos(yaw_rad + turn), np.sin(yaw_rad + turn)]) * length
        targets = np.clip(here[:, None] + way, -half, half)
        share = np.linspace(0.1, 1.0, _POINTS)
        x, y = here[:, None, None] + (targets - here[:, None])[..., None] * share
        solid = self._room.solid_m(x, y).min(axis=1) - self._half_width_m
        soft = self._room.soft_m(x, y).min(axis=1) - self._half_width_m
        near = np.hypot(*(targets - here[:, None])) < 0.6
        score = np.minimum(solid, _MARGIN_M) + 0.3 * np.minimum(soft, 0.0) - 0.05 * np.abs(turn) - near
        best = int(np.argmax(score))
        return float(targets[0, best]), float(targets[1, best])
