"""The body on its tyres: it follows the ground under its wheels, and is shaken by it."""

import math

from navtool.sim.wheeled.config import GRAVITY_MPS2, STEP_S, WheeledConfig


class Tyres:
    """Height, roll and pitch as three damped springs between the ground and the body.

    The tyres push and never pull: the body falls no faster than it would freely.
    """

    def __init__(self, config: WheeledConfig) -> None:
        rate = 2 * math.pi * config.bounce_hz
        self._stiffness, self._damping = rate * rate, 2 * config.bounce_damping * rate
        self.value = [0.0, 0.0, 0.0]
        """Height in m, roll and pitch in rad."""
        self.rate = [0.0, 0.0, 0.0]
        self.load = 1.0
        """How hard the tyres press, over the robot's weight."""
        self._ground = [0.0, 0.0, 0.0]

    def reset(self, height_m: float, roll_rad: float, pitch_rad: float) -> None:
        """Stand at rest on a ground."""
        self.value, self._ground = [height_m, roll_rad, pitch_rad], [height_m, roll_rad, pitch_rad]
        self.rate, self.load = [0.0, 0.0, 0.0], 1.0

    def step(self, height_m: float, roll_rad: float, pitch_rad: float, *, nod_radps: float) -> None:
        """Follow the ground for a step; a blow makes it nod."""
        self.rate[2] += nod_radps
        for axis, ground in enumerate((height_m, roll_rad, pitch_rad)):
            rising = (ground - self._ground[axis]) / STEP_S
            self._ground[axis] = ground
            push = self._stiffness * (ground - self.value[axis]) + self._damping * (rising - self.rate[axis])
            if axis == 0:
                push = max(push, -GRAVITY_MPS2)
                self.load = 1.0 + push / GRAVITY_MPS2
            self.rate[axis] += push * STEP_S
            self.value[axis] += self.rate[axis] * STEP_S
