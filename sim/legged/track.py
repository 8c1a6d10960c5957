"""A whole drive of the quadruped: what happened, what it measured, and what went wrong."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.drive.failure import Failure
from navtool.sim.legged.body import STEP_S
from navtool.sim.legged.controller_config import CONTROL_S
from navtool.sim.legged.failures import find_failures
from navtool.sim.legged.gaits import GaitName
from navtool.sim.legged.proprioception import Proprioception, SensorConfig, measure
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.samples import Samples

_AFTER_FALL_S = 1.0


class Order(NamedTuple):
    """One stretch of a scripted drive."""

    duration_s: float
    """Rounded to the controller's step."""
    speed_mps: float
    turn_radps: float = 0.0
    gait: GaitName | None = None
    """None keeps the gait."""


@dataclass(frozen=True, slots=True)
class LeggedTrack:
    """The truth of a drive and what the robot measured on it."""

    truth: Samples
    measured: Proprioception
    failures: tuple[Failure, ...]

    @property
    def time_s(self) -> Float64[Array, "n"]:
        """Of each sample of the truth, since the reset."""
        return STEP_S * np.arange(len(self.truth.fallen))


def track_of(robot: LeggedRobot, seed: int, sensors: SensorConfig | None = None) -> LeggedTrack:
    """Return what a robot has done since its last reset.

    Args:
        robot: A robot that has made at least one step.
        seed: Decides the sensors' errors.
        sensors: The sensors' errors; None takes the defaults.
    """
    samples = robot.samples()
    return LeggedTrack(samples, measure(samples, seed, sensors), find_failures(samples, robot.obstacles))


def roll_out(
    robot: LeggedRobot, script: Sequence[Order], seed: int, sensors: SensorConfig | None = None
) -> LeggedTrack:
    """Return what happens when a robot follows a script from where it is.

    A robot that falls is given one more second, in which it comes to rest.
    """
    after_s = 0.0
    for order in script:
        if order.gait is not None:
            robot.set_gait(order.gait)
        for _ in range(round(order.duration_s / CONTROL_S)):
            state = robot.step(order.speed_mps, order.turn_radps)
            after_s += CONTROL_S if state.fallen else 0.0
            if after_s >= _AFTER_FALL_S:
                return track_of(robot, seed, sensors)
    return track_of(robot, seed, sensors)
