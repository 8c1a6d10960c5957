"""What the ground under the robot is like, as far as its feet can feel."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError


@dataclass(frozen=True, slots=True)
class Grip:
    """How the ground holds and resists at n places."""

    friction: Float64[Array, " n"]
    """Coulomb's coefficient between foot and ground, above 0."""
    stiffness_npm: Float64[Array, " n"]
    """Newtons for each metre that a foot sinks in; above 0. Its weight over this is how deep a foot stands."""
    damping_nspm: Float64[Array, " n"]
    """Newtons for each metre a second at which a foot sinks in or comes out; 0 or more. Much of it keeps the ground
    from springing back: the foot leaves before its print has filled up."""
    drag_nspm2: Float64[Array, " n"]
    """What grows or lies there resists a limb with this force, in newtons for each metre of limb inside it and each
    metre a second across it; 0 on bare ground."""
    cover_m: Float64[Array, " n"]
    """How high it grows above the ground, 0 on bare ground."""
    stems_n: Float64[Array, " n"]
    """Bending stiffness of the stems that stand there: E I, summed over a square metre; 0 or more."""


@runtime_checkable
class Footing(Protocol):
    """A ground of any kind: heights on a regular grid, and how it holds at any place.

    Each cell is split from its low x, low y corner to its high x, high y corner into two flat triangles.
    """

    @property
    def origin_m(self) -> tuple[float, float]:
        """World x and y of the first height."""

    @property
    def cell_m(self) -> float:
        """Distance between two neighbouring heights; above 0."""

    @property
    def heights_m(self) -> Float64[Array, "rows columns"]:
        """World z; rows follow y, columns x."""

    def grip_at(self, x_m: Float64[Array, " n"], y_m: Float64[Array, " n"]) -> Grip:
        """Return how the ground holds at places in the world."""


def check_footing(footing: Footing) -> None:
    """Refuse a ground that no robot can stand on.

    Raises:
        SimError: The grid is smaller than 2 x 2, has no extent, or holds a height that is not a number.
    """
    heights = footing.heights_m
    if min(heights.shape) < 2 or footing.cell_m <= 0:
        what = f"a footing of {heights.shape} heights {footing.cell_m} m apart"
        raise SimError(what, cure="give at least 2 x 2 heights at a distance above 0")
    bad = int(np.count_nonzero(~np.isfinite(heights)))
    if bad:
        raise SimError(f"{bad} of {heights.size} heights of a footing are not finite", cure="fill the holes first")
