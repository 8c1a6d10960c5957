"""The ground as the physics asks for it: the plane that a ball touches, and how the ground holds there."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.legged.footing import Footing, check_footing

_OUT = 0.7
"""How far from a ball's lowest point the ground is looked at, in radii."""
_RING = _OUT * np.array([(0.0, 0.0), *((np.cos(a), np.sin(a)) for a in np.arange(8) * np.pi / 4)])
_RING_LIFT = np.array([1.0, *(np.sqrt(1.0 - _OUT**2),) * 8])


class Contact(NamedTuple):
    """The plane that each of n balls meets first. World frame."""

    point_m: Float64[Array, "n 3"]
    normal: Float64[Array, "n 3"]
    grip: Float64[Array, "n 6"]
    """Friction, stiffness (N/m), damping (N s/m), drag (N s/m2), cover (m) and stems (N) of the ground there."""


class Terrain:
    """Looks up a footing fast. Outside its grid the ground goes on as at its rim.

    Args:
        footing: The ground; its grip is read once, at the middle of each cell.

    Raises:
        SimError: The footing is none (see `check_footing`), or its grip is out of range.
    """

    def __init__(self, footing: Footing) -> None:
        check_footing(footing)
        heights = np.asarray(footing.heights_m, dtype=np.float64)
        corner, right, up, far = heights[:-1, :-1], heights[:-1, 1:], heights[1:, :-1], heights[1:, 1:]
        upper = [corner, far - up, up - corner]
        lower = [corner, right - corner, far - right]
        # two triangles a cell, each with its height at the cell's corner and its rise across the cell along x and y
        self._triangles = np.stack([np.stack(upper, axis=-1), np.stack(lower, axis=-1)], axis=2).reshape(-1, 3)
        rows, self._columns = corner.shape
        self._origin = np.array(footing.origin_m, dtype=np.float64)
        self._per_m = 1.0 / footing.cell_m
        self._last = np.array([self._columns - 1e-9, rows - 1e-9])
        x, y = (
            start + footing.cell_m * (np.arange(cells) + 0.5)
            for start, cells in zip(footing.origin_m, (self._columns, rows), strict=True)
        )
        across, along = np.meshgrid(x, y)
        grip = footing.grip_at(across.reshape(-1), along.reshape(-1))
        self._grip = np.stack(
            [grip.friction, grip.stiffness_npm, grip.damping_nspm, grip.drag_nspm2, grip.cover_m, grip.stems_n], axis=-1
        )
        low = self._grip.min(axis=0)
        if not (np.isfinite(self._grip).all() and low[0] > 0 and low[1] > 0 and low[2:].min() >= 0):
            what = f"the least friction, stiffness, damping, drag, cover and stems of a footing are {low.tolist()}"
            raise SimError(what, cure="friction and stiffness must be above 0, the others 0 or more, all finite")

    def height(self, xy: Float64[Array, "*any 2"]) -> Float64[Array, "*any"]:
        """Return the ground's height at places, on the triangles between the grid's heights."""
        number, share = self._locate(xy)
        plane = self._triangles[number]
        return np.asarray(plane[..., 0] + share[..., 0] * plane[..., 1] + share[..., 1] * plane[..., 2])

    def contact(self, centre_m: Float64[Array, "n 3"], radius_m: Float64[Array, " n"]) -> Contact:
        """Return the plane that each ball meets first when it sinks.

        Of nine places under a ball, that counts at which the ground reaches highest into it, so that a foot rests on
        the edge of a stone and knocks against its flank.
        """
        places = centre_m[:, None, :2] + radius_m[:, None, None] * _RING
        number, share = self._locate(places)
        plane = self._triangles[number]
        plane[..., 1:] *= share
        height = plane.sum(axis=-1)
        best = (height + radius_m[:, None] * _RING_LIFT).argmax(axis=1)
        row = np.arange(best.size)
        point = np.empty((best.size, 3))
        point[:, :2] = places[row, best]
        point[:, 2] = height[row, best]
        met = number[row, best]
        normal = np.empty((best.size, 3))
        normal[:, :2] = -self._per_m * self._triangles[met, 1:]
        normal[:, 2] = 1.0
        normal /= np.sqrt((normal * normal).sum(axis=1))[:, None]
        return Contact(point, normal, self._grip[met >> 1])

    def _locate(self, xy: Array) -> tuple[Array, Array]:
        """Return the numbers of the triangles that places lie in, and how far along x and y in their cells, 0-1."""
        at = (xy - self._origin) * self._per_m
        np.maximum(at, 0.0, out=at)
        np.minimum(at, self._last, out=at)
        whole = at.astype(np.intp)
        at -= whole
        u, v = at[..., 0], at[..., 1]
        return 2 * (whole[..., 1] * self._columns + whole[..., 0]) + (u >= v), at
