"""A wheeled robot on level ground: how it follows commands, hits what is solid and sinks into what is not."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from navtool.sim.scene import Thing

STEP_S = 0.01


@dataclass(kw_only=True, slots=True)
class RobotLimits:
    """Size and dynamics of the robot."""

    radius_m: float = 0.35
    """Radius of its round footprint; above 0."""
    max_speed_mps: float = 1.0
    """Fastest forward or backward motion; above 0."""
    max_turn_radps: float = 0.9
    """Fastest turn on the spot; above 0."""
    max_acceleration_mps2: float = 1.5
    """Strongest acceleration by its own motors; above 0."""
    impact_deceleration_mps2: float = 25.0
    """Deceleration when it hits a solid thing: far beyond what its brakes do."""
    lag_s: float = 0.15
    """Time constant with which the motors follow a command; above 0."""


@dataclass(slots=True)
class RobotState:
    """Where the robot is and how it moves. World frame, metres and radians."""

    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float = 0.0
    turn_radps: float = 0.0
    contact: bool = False
    """Whether it pushes against a solid thing."""
    grip: float = 1.0
    """Share of the commanded speed that vegetation leaves it, 0-1."""


class Robot:
    """Advances a robot through the things of a scene in steps of ``STEP_S``."""

    def __init__(self, obstacles: tuple[Thing, ...], limits: RobotLimits) -> None:
        self.limits = limits
        self._solid = tuple(thing for thing in obstacles if thing.material.solid)
        self._soft = tuple(thing for thing in obstacles if not thing.material.solid)

    def clearance(self, xy: Float[np.ndarray, "2 ..."], *, soft: bool = True) -> Float[np.ndarray, "..."]:
        """Return the distance in metres from the footprint's rim at points to the nearest thing, negative inside."""
        things = (*self._solid, *self._soft) if soft else self._solid
        if not things:
            return np.full(xy.shape[1:], np.inf)
        return np.min([thing.shape.clearance(xy) for thing in things], axis=0) - self.limits.radius_m

    def step(self, state: RobotState, speed_mps: float, turn_radps: float, *, lifted: bool = False) -> RobotState:
        """Return the state one step later under a commanded speed and turn.

        Args:
            state: The state now.
            speed_mps: Commanded forward speed; clipped to the limits.
            turn_radps: Commanded turn rate; clipped to the limits.
            lifted: Whether an operator frees it, so that vegetation does not hold it.
        """
        limits = self.limits
        here = np.array([state.x_m, state.y_m])
        grip = 1.0 if lifted else self._grip(here)
        wanted = float(np.clip(speed_mps, -limits.max_speed_mps, limits.max_speed_mps)) * grip
        turn = float(np.clip(turn_radps, -limits.max_turn_radps, limits.max_turn_radps)) * max(grip, 0.0)
        change = (wanted - state.speed_mps) * STEP_S / limits.lag_s
        most = limits.max_acceleration_mps2 * STEP_S
        speed = state.speed_mps + float(np.clip(change, -most, most))
        rate = state.turn_radps + (turn - state.turn_radps) * STEP_S / limits.lag_s
        heading = np.array([np.cos(state.yaw_rad), np.sin(state.yaw_rad)])
        ahead = here + heading * (0.03 * np.sign(wanted if abs(state.speed_mps) < 0.02 else state.speed_mps))
        now, then = self.clearance(here, soft=False), self.clearance(ahead, soft=False)
        contact = bool(then < 0.0 and then < now)
        if contact:
            stop = limits.impact_deceleration_mps2 * STEP_S
            speed = float(np.sign(state.speed_mps)) * max(0.0, abs(state.speed_mps) - stop)
        middle = state.yaw_rad + 0.5 * rate * STEP_S
        return RobotState(
            x_m=state.x_m + speed * STEP_S * float(np.cos(middle)),
            y_m=state.y_m + speed * STEP_S * float(np.sin(middle)),
            yaw_rad=state.yaw_rad + rate * STEP_S,
            speed_mps=speed,
            turn_radps=rate,
            contact=contact,
            grip=grip,
        )

    def _grip(self, here: Float[np.ndarray, "2"]) -> float:
        """Return the share of its speed that is left: it falls linearly with the depth inside each soft thing."""
        held = 0.0
        for thing in self._soft:
            depth = self.limits.radius_m - float(thing.shape.clearance(here))
            if depth > 0:
                held += min(depth, 0.9) * thing.material.drag_per_m
        return max(0.0, 1.0 - held)
