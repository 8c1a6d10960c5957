"""The ground as four wheels feel it, looked up fast."""

import numpy as np
from jaxtyping import Float64
from scipy import ndimage

from navtool.pipeline.arrays import Array
from navtool.sim.wheeled.config import BASE_HEIGHT_M
from navtool.sim.world.mesh import TriangleMesh
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import SURFACES, surface_number, surface_values

FOOT_CM2, TYRE_CM2 = 20.0, 114.0
"""Areas over which a surface's stiffness is given, and of a tyre's print: 0.114 m wide, and 0.1 m long."""
WHEEL_LOAD_N = 50.0 * 9.81 / 4
ADHESION = 0.2
"""Rolling resistance for a surface's drag: what sticks to the tyres and is pushed along. Chosen."""
BLADE_AREA = 0.30
"""Area of blades over an area of ground at which tall grass drags as its surface says: that of a patch's middle."""
_ENVELOPE_M = 0.05
"""A tyre gives way to what is shorter: deviation of the Gaussian by which the ground is smoothed under it."""


def rolling_resistance() -> Float64[Array, " surfaces"]:
    r"""Force against rolling over load, by surface number.

    .. math::
        \sqrt{z / D} + a \, d

    z is how deep the tyre sinks in: its load over the surface's stiffness, which grows with the area pressed; D the
    wheel's diameter; d the surface's drag, a ``ADHESION``. Reference: Gerstner's and Grandvoinet's rule for wheels on
    soft ground. It gives concrete 0.02, gravel 0.05, grass 0.06, sand 0.09, mulch 0.1 and mud 0.23.
    """
    stiffness = surface_values("stiffness_npm").astype(np.float64) * (TYRE_CM2 / FOOT_CM2)
    sunk = np.sqrt(WHEEL_LOAD_N / stiffness / (2 * BASE_HEIGHT_M))
    return np.asarray(sunk + ADHESION * surface_values("drag_per_m"))


class Footing:
    """Heights, slopes, friction and resistance of a place's ground under a wheel; outside the grid as at its rim.

    The wheels roll over the ground's envelope: a wheel does not go into a pit that is narrower than itself, and begins
    to climb a stone before its hub is over it. Tall grass drags by its blades: in the middle of a dense patch more
    than at its rim, most where patches overlap.
    """

    def __init__(self, world: World) -> None:
        ground = world.ground
        self._per_m, self._half = 1.0 / ground.cell_m, len(ground.surface) / 2
        self._cells = len(ground.surface)
        heights = _envelope(ground.heights_m, ground.cell_m)
        self._heights: list[float] = heights.ravel().tolist()
        self._surface: list[int] = ground.surface.ravel().tolist()
        of_ground = surface_values("drag_per_m")[ground.surface]
        plants = np.maximum(ground.drag_per_m - of_ground, 0.0)
        dense = _blades(world.mesh, self._cells, ground.cell_m) / BLADE_AREA
        grass = np.float32(SURFACES[surface_number("tall_grass")].drag_per_m) * dense
        # what grows is dragged through with its whole density; leaves and beads as the place says
        plants = np.where(dense > 0.05, np.maximum(grass, 0.0), plants)
        self._plants: list[float] = plants.ravel().tolist()
        self._friction: list[float] = surface_values("friction").tolist()
        self._rolling: list[float] = rolling_resistance().tolist()
        self._drag: list[float] = surface_values("drag_per_m").tolist()

    def at(self, x_m: float, y_m: float) -> tuple[float, float, float, float, float, float, float, int]:
        """Height, rise along x and y, friction, rolling resistance, drag of ground and of plants, surface."""
        u, v = x_m * self._per_m + self._half, y_m * self._per_m + self._half
        last = self._cells - 1
        column = 0 if u < 0.0 else last if u >= self._cells else int(u)
        row = 0 if v < 0.0 else last if v >= self._cells else int(v)
        u, v = min(max(u - column, 0.0), 1.0), min(max(v - row, 0.0), 1.0)
        node = row * (self._cells + 1) + column
        heights = self._heights
        a, b = heights[node], heights[node + 1]
        c, d = heights[node + self._cells + 1], heights[node + self._cells + 2]
        twist = d - b - c + a
        cell = row * self._cells + column
        surface = self._surface[cell]
        return (
            a + (b - a) * u + (c - a + twist * u) * v,
            (b - a + twist * v) * self._per_m,
            (c - a + twist * u) * self._per_m,
            self._friction[surface],
            self._rolling[surface],
            self._drag[surface],
            self._plants[cell],
            surface,
        )


def _envelope(heights_m: Float64[Array, "m m"], cell_m: float) -> Float64[Array, "m m"]:
    """How high a ball of a wheel's radius reaches down over each node, above the ground where the ground is level."""
    reach = int(BASE_HEIGHT_M / cell_m)
    along = np.arange(-reach, reach + 1) * cell_m
    apart = along[:, None] ** 2 + along[None, :] ** 2
    inside = apart < BASE_HEIGHT_M**2
    drop = np.sqrt(np.where(inside, BASE_HEIGHT_M**2 - apart, 0.0)) - BASE_HEIGHT_M
    rolled = ndimage.grey_dilation(heights_m, footprint=inside, structure=drop, mode="nearest")
    return np.asarray(ndimage.gaussian_filter(rolled, _ENVELOPE_M / cell_m, mode="nearest"))


def _blades(mesh: TriangleMesh, cells: int, cell_m: float) -> Float64[Array, "n n"]:
    """Area of tall grass's blades over each cell's area, a mean over its neighbours and itself."""
    mine = mesh.surface == surface_number("tall_grass")
    corners = mesh.vertices[mesh.triangles[mine]].astype(np.float64)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    column, row = (np.floor(corners[:, :, axis].mean(axis=1) / cell_m + cells / 2).astype(np.int64) for axis in (0, 1))
    there = (column >= 0) & (column < cells) & (row >= 0) & (row < cells)
    total = np.bincount(row[there] * cells + column[there], area[there], cells * cells).reshape(cells, cells)
    return np.asarray(ndimage.uniform_filter(total, round(0.5 / cell_m) | 1, mode="constant") / cell_m**2)
