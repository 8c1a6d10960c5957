"""The ground: a grid of heights and of what it is made of."""

from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float, Float32, Float64, Int, UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.world.mesh import TriangleMesh
from navtool.sim.world.surfaces import surface_values

SKIRT_M = 140.0
"""Half the side of the level ground around the grid: sensors see it, nobody walks there."""
SKIRT_TRIANGLES = 8
"""How many triangles that ground has."""


@dataclass(frozen=True, slots=True)
class HeightField:
    """A square of ground, centred on the origin of the world.

    Each cell is split from its low x, low y node to its high x, high y node into two flat triangles: ``height_at`` lies
    exactly on the triangles of ``mesh``, so that what a sensor sees is what a foot feels. Beyond the edge of the grid
    everything is as on the edge, where the ground is level.

    Raises:
        ValueError: The heights at the edge are not 0.
    """

    cell_m: float
    """Side of a cell."""
    heights_m: Float64[Array, "n1 n1"]
    """Height of each node, rows along y, columns along x."""
    surface: UInt8[Array, "n n"]
    """Number of each cell's surface."""
    drag_per_m: Float32[Array, "n n"]
    """Share of its speed that a body loses per metre in a cell: that of its surface and of what grows on it."""
    half_side_m: float = field(init=False)
    """Half the side of the square."""

    def __post_init__(self) -> None:
        rim = (self.heights_m[0], self.heights_m[-1], self.heights_m[:, 0], self.heights_m[:, -1])
        if any(edge.any() for edge in rim):
            raise ValueError("the ground has to come down to a height of 0 at its edge")
        object.__setattr__(self, "half_side_m", 0.5 * self.cell_m * len(self.surface))

    def height_at(self, x_m: Float[Array, "*n"], y_m: Float[Array, "*n"]) -> Float64[Array, "*n"]:
        """The height of the ground at points."""
        row, column, along_x, along_y = self._within(x_m, y_m)
        h, rise_x, rise_y = self._plane(row, column, along_x, along_y)
        return np.asarray(h + rise_x * along_x + rise_y * along_y)

    def normal_at(self, x_m: Float[Array, "*n"], y_m: Float[Array, "*n"]) -> Float64[Array, "*n 3"]:
        """The unit normal of the ground's triangle at points, pointing up."""
        _, rise_x, rise_y = self._plane(*self._within(x_m, y_m))
        normal = np.stack([-rise_x / self.cell_m, -rise_y / self.cell_m, np.ones_like(rise_x)], axis=-1)
        return np.asarray(normal / np.linalg.norm(normal, axis=-1, keepdims=True))

    def surface_at(self, x_m: Float[Array, "*n"], y_m: Float[Array, "*n"]) -> UInt8[Array, "*n"]:
        """The number of the surface at points."""
        row, column, _, _ = self._within(x_m, y_m)
        return np.asarray(self.surface[row, column])

    def drag_at(self, x_m: Float[Array, "*n"], y_m: Float[Array, "*n"]) -> Float32[Array, "*n"]:
        """The share of its speed that a body loses per metre at points."""
        row, column, _, _ = self._within(x_m, y_m)
        return np.asarray(self.drag_per_m[row, column])

    def contact_at(self, x_m: Float[Array, "*n"], y_m: Float[Array, "*n"], quantity: str) -> Float32[Array, "*n"]:
        """``friction``, ``stiffness_npm`` or ``damping_nspm`` of the surface at points."""
        return surface_values(quantity)[self.surface_at(x_m, y_m)]

    def mesh(self) -> TriangleMesh:
        """Two triangles a cell, row by row, and then the ``SKIRT_TRIANGLES`` of the level ground around the square."""
        side = len(self.surface)
        axis = (np.arange(side + 1) - side / 2) * self.cell_m
        x, y = np.meshgrid(axis, axis)
        nodes = np.stack([x, y, self.heights_m], axis=-1).reshape(-1, 3)
        row, column = np.divmod(np.arange(side * side), side)
        a = row * (side + 1) + column
        b, c, d = a + 1, a + side + 2, a + side + 1
        halves = np.stack([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)], axis=1).reshape(-1, 3)
        square = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
        rim = np.concatenate([square * self.half_side_m, square * SKIRT_M])
        skirt = np.array([face for i in range(4) for j in [(i + 1) % 4] for face in ((i, 4 + i, 4 + j), (i, 4 + j, j))])
        edge = np.concatenate([self.surface[0], self.surface[-1], self.surface[:, 0], self.surface[:, -1]])
        around = np.full(SKIRT_TRIANGLES, np.bincount(edge).argmax(), np.uint8)
        return TriangleMesh(
            np.concatenate([nodes, rim]).astype(np.float32),
            np.concatenate([halves, skirt + len(nodes)]).astype(np.int32),
            np.concatenate([np.repeat(self.surface.ravel(), 2), around]),
        )

    def _within(self, x_m: Array, y_m: Array) -> tuple[Int[Array, "*n"], Int[Array, "*n"], Array, Array]:
        """Row, column and the position within the cell, both axes 0-1."""
        side = len(self.surface)
        u = np.clip(np.asarray(x_m, np.float64) / self.cell_m + side / 2, 0.0, side)
        v = np.clip(np.asarray(y_m, np.float64) / self.cell_m + side / 2, 0.0, side)
        column, row = np.minimum(u.astype(np.int64), side - 1), np.minimum(v.astype(np.int64), side - 1)
        return row, column, u - column, v - row

    def _plane(
        self, row: Int[Array, "*n"], column: Int[Array, "*n"], along_x: Array, along_y: Array
    ) -> tuple[Array, Array, Array]:
        """Height at the cell's first node, and the rise across the cell along x and along y, of the triangle there."""
        a, c = self.heights_m[row, column], self.heights_m[row + 1, column + 1]
        b, d = self.heights_m[row, column + 1], self.heights_m[row + 1, column]
        lower = along_x >= along_y
        return a, np.where(lower, b - a, c - d), np.where(lower, c - b, d - a)
