"""What is in a robot's way, as outlines on the ground."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Float64

from navtool.pipeline.arrays import Array
from navtool.sim.world.surfaces import SURFACES


@dataclass(frozen=True, slots=True, kw_only=True)
class Obstacle:
    """One thing's outline: a circle, or a rectangle turned about the vertical. World frame, metres."""

    kind: str
    """trunk, bush, grass_patch, rock, wall, pillar, glass, curtain."""
    surface: int
    """Number of the surface that a robot touches first."""
    x_m: float
    y_m: float
    half_length_m: float
    """Radius of a circle; half the length of a rectangle, along x before it is turned."""
    half_width_m: float | None = None
    """Half the width of a rectangle; None for a circle."""
    yaw_rad: float = 0.0
    height_m: float
    """Height of its top above the ground."""

    @property
    def pliable(self) -> bool:
        """Whether a robot can push through it."""
        return SURFACES[self.surface].pliable


@dataclass(frozen=True, slots=True)
class Obstacles:
    """Many outlines and how far points are from them; immutable."""

    items: tuple[Obstacle, ...]
    _boxes: Float64[Array, "n 5"] = field(init=False, repr=False)
    """x, y, half length and half width without the corners' radius, corners' radius."""
    _turn: Float64[Array, "n 2"] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        rows = [
            (item.x_m, item.y_m, 0.0, 0.0, item.half_length_m)
            if item.half_width_m is None
            else (item.x_m, item.y_m, item.half_length_m, item.half_width_m, 0.0)
            for item in self.items
        ]
        object.__setattr__(self, "_boxes", np.array(rows, np.float64).reshape(-1, 5))
        yaw = np.array([item.yaw_rad for item in self.items], np.float64)
        object.__setattr__(self, "_turn", np.stack([np.cos(yaw), np.sin(yaw)], axis=1).reshape(-1, 2))

    def distances(self, x_m: Float[Array, "*p"], y_m: Float[Array, "*p"]) -> Float64[Array, " n *p"]:
        """The distance in metres of points from each outline, negative inside."""
        shape = (-1, *[1] * x_m.ndim)
        x, y, half_length, half_width, radius = (column.reshape(shape) for column in self._boxes.T)
        cos, sin = (column.reshape(shape) for column in self._turn.T)
        along = np.abs(cos * (x_m - x) + sin * (y_m - y)) - half_length
        across = np.abs(cos * (y_m - y) - sin * (x_m - x)) - half_width
        outside = np.hypot(np.maximum(along, 0.0), np.maximum(across, 0.0))
        return np.asarray(outside + np.minimum(np.maximum(along, across), 0.0) - radius)

    def clearance(self, x_m: Float[Array, "*p"], y_m: Float[Array, "*p"]) -> Float64[Array, "*p"]:
        """The distance in metres of points from the nearest outline, negative inside; infinite where there is none."""
        return np.asarray(self.distances(x_m, y_m).min(axis=0, initial=np.inf))

    def only(self, *, pliable: bool) -> "Obstacles":
        """Those that yield, or those that do not."""
        return Obstacles(tuple(item for item in self.items if item.pliable is pliable))
