"""A whole drive of the quadruped: what happened, what it measured, and what went wrong."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.drive.failure import Failure
from navtool.sim.legged.body import STEP_S
from navtool.sim.legged.failures import find_failures
from navtool.sim.legged.proprioception import Proprioception, SensorConfig, measure
from navtool.sim.legged.robot import LeggedRobot
from navtool.sim.legged.samples import Samples


@dataclass(frozen=True, slots=True)
class LeggedTrack:
    """The truth of a drive and what the robot measured on it."""

    truth: Samples
    measured: Proprioception
    failures: tuple[Failure, ...]

    @property
    def time_s(self) -> Float64[Array, " n"]:
        """Time of each step of the truth, since the reset."""
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
