"""What a driver knows of a place: how far it goes, what stands there, and whether a way is clear."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.world.place import World

_BESIDE_M, _BEYOND_M, _EDGE_M = 9.0, 3.0, 4.0
"""A driver stays this close beside the straight course, beyond its ends, and this far within the modelled square."""


class Thing(NamedTuple):
    """Something that a driver can be careless about."""

    x_m: float
    y_m: float
    pliable: bool


class Surroundings:
    """A place as a driver sees it.

    Attributes:
        half_extent_m: Half the sides of the rectangle about the world's origin in which a driver roams.
        things: All that stands and grows there.
    """

    def __init__(self, world: World) -> None:
        config, room = world.config, world.config.room
        edge = world.ground.half_side_m - _EDGE_M
        if room is not None:
            self.half_extent_m = room.length_m / 2, room.width_m / 2
        else:
            self.half_extent_m = min(config.course_m / 2 + _BEYOND_M, edge), min(_BESIDE_M, edge)
        self._solid = world.obstacles.only(pliable=False)
        self._soft = world.obstacles.only(pliable=True)
        self.things = tuple(
            Thing(item.x_m, item.y_m, item.pliable)
            for item in world.obstacles.items
            if abs(item.x_m) <= self.half_extent_m[0] and abs(item.y_m) <= self.half_extent_m[1]
        )

    def inside(self, x_m: Float64[Array, "*n"], y_m: Float64[Array, "*n"], margin_m: float) -> Array:
        """Whether points are within the rectangle, by a margin."""
        half_x, half_y = self.half_extent_m
        return np.asarray((np.abs(x_m) <= half_x - margin_m) & (np.abs(y_m) <= half_y - margin_m))

    def solid_m(self, x_m: Float64[Array, "*n"], y_m: Float64[Array, "*n"]) -> Float64[Array, "*n"]:
        """The distance of points from what does not yield."""
        return self._solid.clearance(x_m, y_m)

    def soft_m(self, x_m: Float64[Array, "*n"], y_m: Float64[Array, "*n"]) -> Float64[Array, "*n"]:
        """The distance of points from what yields, such as tall grass."""
        return self._soft.clearance(x_m, y_m)
