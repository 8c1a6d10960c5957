"""A wheeled robot on level ground: how it follows commands, hits what is solid and sinks into what is not."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.sim.scene import Thing
from navtool.sim.shapes import Box, Shape

STEP_S = 0.01
_FEELER_M = 0.03
"""How far ahead along its motion the footprint is tested for contact."""


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
        self._solid = _Outlines(tuple(thing.shape for thing in obstacles if thing.material.solid))
        soft = tuple(thing for thing in obstacles if not thing.material.solid)
        self._soft = _Outlines(tuple(thing.shape for thing in soft))
        self._drag_per_m = np.array([thing.material.drag_per_m for thing in soft])

    def clearance(self, xy: Float[Array, "2 n"]) -> Float[Array, "n"]:
        """Return the distance in metres from the footprint's rim at points to the nearest thing, negative inside."""
        nearest = np.minimum(self._solid.clearance(*xy).min(axis=0), self._soft.clearance(*xy).min(axis=0))
        return np.asarray(nearest - self.limits.radius_m)

    def step(self, state: RobotState, speed_mps: float, turn_radps: float, *, lifted: bool = False) -> RobotState:
        """Return the state one step later under a commanded speed and turn.

        Args:
            state: The state now.
            speed_mps: Commanded forward speed; clipped to the limits.
            turn_radps: Commanded turn rate; clipped to the limits.
            lifted: Whether an operator frees it, so that vegetation does not hold it.
        """
        limits = self.limits
        heading_x, heading_y = math.cos(state.yaw_rad), math.sin(state.yaw_rad)
        grip = 1.0 if lifted else self._grip(state.x_m, state.y_m)
        wanted = _bounded(speed_mps, limits.max_speed_mps) * grip
        turn = _bounded(turn_radps, limits.max_turn_radps) * grip
        change = (wanted - state.speed_mps) * STEP_S / limits.lag_s
        speed = state.speed_mps + _bounded(change, limits.max_acceleration_mps2 * STEP_S)
        rate = state.turn_radps + (turn - state.turn_radps) * STEP_S / limits.lag_s
        tip = math.copysign(_FEELER_M, wanted if abs(state.speed_mps) < 0.02 else state.speed_mps)
        x, y = np.array([state.x_m, state.x_m + tip * heading_x]), np.array([state.y_m, state.y_m + tip * heading_y])
        now, then = self._solid.clearance(x, y).min(axis=0).tolist()
        contact = then < limits.radius_m and then < now
        if contact:
            stop = limits.impact_deceleration_mps2 * STEP_S
            speed = math.copysign(max(0.0, abs(state.speed_mps) - stop), state.speed_mps)
        middle = state.yaw_rad + 0.5 * rate * STEP_S
        return RobotState(
            x_m=state.x_m + speed * STEP_S * math.cos(middle),
            y_m=state.y_m + speed * STEP_S * math.sin(middle),
            yaw_rad=state.yaw_rad + rate * STEP_S,
            speed_mps=speed,
            turn_radps=rate,
            contact=contact,
            grip=grip,
        )

    def _grip(self, x_m: float, y_m: float) -> float:
        """Return the share of its speed that is left: it falls linearly with the depth inside each soft thing."""
        depth = self.limits.radius_m - self._soft.clearance(np.array([x_m]), np.array([y_m]))[:-1, 0]
        held = float(np.minimum(np.maximum(depth, 0.0), 0.9) @ self._drag_per_m)
        return max(0.0, 1.0 - held)


def _bounded(value: float, most: float) -> float:
    return max(-most, min(most, value))


class _Outlines:
    """The outlines of many bodies on the ground, the round ones in one array."""

    def __init__(self, shapes: tuple[Shape, ...]) -> None:
        rounds = [(shape.x, shape.y, shape.radius) for shape in shapes if not isinstance(shape, Box)]
        self._x, self._y, self._radius = np.array(rounds).reshape(-1, 3).T[..., None]
        self._boxes = [shape for shape in shapes if isinstance(shape, Box)]

    def clearance(self, x: Array, y: Array) -> Array:
        """Return the distance of n points to each round body, each box, and to nothing (infinite): (bodies + 1, n)."""
        around = np.sqrt((x - self._x) ** 2 + (y - self._y) ** 2) - self._radius
        boxes = (box.clearance(np.stack([x, y]))[None] for box in self._boxes)
        return np.concatenate([around, *boxes, np.full((1, x.size), np.inf)])
