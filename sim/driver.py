"""A careless driver: goes about a place, now and then straight into what stands there, and is freed when stuck."""

from enum import Enum, auto
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.sim.robot import Robot, RobotState
from navtool.sim.scene import REACH_M, Thing


class Mode(Enum):
    """What the driver is doing."""

    CRUISE = auto()
    PUSH = auto()
    """Still commanding forward against what the robot has hit."""
    BACK_OFF = auto()
    STUCK = auto()
    """Commanding forward in vegetation that holds the robot."""
    RESCUE = auto()
    """The operator pulls the robot out."""


class Command(NamedTuple):
    """What is asked of the robot."""

    speed_mps: float
    turn_radps: float
    intervention: bool


class Driver:
    """Decides the command from the robot's state; all chance comes from one generator."""

    def __init__(self, robot: Robot, obstacles: tuple[Thing, ...], mischief: float, rng: np.random.Generator) -> None:
        """Take the wheel.

        Args:
            robot: The robot that is driven.
            obstacles: What it can be driven into.
            mischief: Share of the legs that lead into an obstacle, 0-1.
            rng: Source of all decisions.
        """
        self.mode = Mode.CRUISE
        self._robot, self._obstacles, self._mischief, self._rng = robot, obstacles, mischief, rng
        self._deadline_s = 0.0
        self._target: Float[Array, " 2"] = np.zeros(2)
        self._speed_mps = 0.0
        self._last = Command(0.0, 0.0, intervention=False)

    def command(self, time_s: float, state: RobotState) -> Command:
        """Return the command for the next moment and note what the driver is up to."""
        over = time_s >= self._deadline_s
        match self.mode:
            case Mode.CRUISE if state.contact:
                self._enter(Mode.PUSH, time_s, 1.0, 2.0)
            case Mode.CRUISE if state.grip < 0.3 and abs(state.speed_mps) < 0.05:
                self._enter(Mode.STUCK, time_s, 2.5, 4.0)
            case Mode.CRUISE:
                self._last = self._pursue(time_s, state, over=over)
            case Mode.PUSH if over:
                self._enter(Mode.BACK_OFF, time_s, 1.2, 2.0)
                self._last = Command(-0.4 * float(np.sign(self._last.speed_mps)), 0.0, intervention=False)
            case Mode.STUCK if over:
                self._enter(Mode.RESCUE, time_s, 2.5, 3.5)
                self._last = Command(-0.35, 0.0, intervention=True)
            case Mode.BACK_OFF | Mode.RESCUE if over or state.contact:
                self.mode = Mode.CRUISE
                self._choose_leg(time_s, state, mischief=0.0)
                self._last = self._pursue(time_s, state, over=False)
        return self._last

    def _enter(self, mode: Mode, time_s: float, shortest_s: float, longest_s: float) -> None:
        self.mode = mode
        self._deadline_s = time_s + self._rng.uniform(shortest_s, longest_s)

    def _pursue(self, time_s: float, state: RobotState, *, over: bool) -> Command:
        """Turn towards the target and go there; take the next one when it is reached or out of reach."""
        offset = self._target - (state.x_m, state.y_m)
        if over or float(np.hypot(*offset)) < 0.4:
            self._choose_leg(time_s, state, mischief=self._mischief)
            offset = self._target - (state.x_m, state.y_m)
        bearing = float(np.arctan2(offset[1], offset[0])) - state.yaw_rad
        error = (bearing + np.pi) % (2 * np.pi) - np.pi
        turn = float(np.clip(1.8 * error, -0.8, 0.8)) + 0.08 * float(np.sin(2.0 * time_s))
        return Command(self._speed_mps * max(0.0, float(np.cos(error))) ** 2, turn, intervention=False)

    def _choose_leg(self, time_s: float, state: RobotState, *, mischief: float) -> None:
        """Set a new target: an obstacle not far ahead, or a point that is reached by a clear straight way."""
        here = np.array([state.x_m, state.y_m])
        self._speed_mps = float(self._rng.uniform(0.5, 1.0))
        self._deadline_s = time_s + 12.0
        if self._rng.random() < mischief:
            centres = np.array([thing.shape.centre[:2] for thing in self._obstacles]) - here
            ahead = np.cos(np.arctan2(centres[:, 1], centres[:, 0]) - state.yaw_rad)
            distance = np.hypot(centres[:, 0], centres[:, 1])
            near = np.flatnonzero((distance > 1.5) & (distance < 7.0) & (ahead > 0.3))
            if near.size:
                self._target = here + centres[self._rng.choice(near)]
                return
        self._target = self._free_target(here, state.yaw_rad)

    def _free_target(self, here: Float[Array, "2"], yaw_rad: float) -> Float[Array, "2"]:
        """Return the target with the widest way among some random ones, those ahead first."""
        turn = self._rng.normal(0.0, 1.0, 24)
        length = self._rng.uniform(2.5, 7.0, 24)
        way = np.stack([np.cos(yaw_rad + turn), np.sin(yaw_rad + turn)]) * length
        targets = np.clip(here[:, None] + way, -REACH_M, REACH_M)
        share = np.linspace(0.1, 1.0, 20)
        points = here[:, None, None] + (targets - here[:, None])[..., None] * share
        clearance = self._robot.clearance(points.reshape(2, -1)).reshape(24, 20)
        score = np.minimum(clearance.min(axis=1), 0.5) - 0.05 * np.abs(turn)
        return np.asarray(targets[:, int(np.argmax(score))])
