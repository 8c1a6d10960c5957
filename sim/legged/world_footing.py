"""A world's ground as the quadruped's feet and limbs find it."""

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.legged.body import MASS_KG
from navtool.sim.legged.footing import Grip
from navtool.sim.legged.ground import standing_length_m
from navtool.sim.legged.stems import stem_rigidity_n
from navtool.sim.world.obstacle import Obstacles
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import SURFACES, surface_number, surface_values

REFERENCE_MPS = 1.0
"""The speed at which limbs and a coasting hull lose the same: a robot's brisk walk."""
LOOSE_M = 0.05
"""Loose ground, mud and short turf resist what is within this height above them."""
WINDING = 10.0
"""How much more leaves and beads hold legs, around which they wind, than a hull that parts them once. Chosen."""
_GRASS = surface_number("tall_grass")


class WorldFooting:
    r"""Heights, contact and drag of a world, by place.

    A world says which share of its speed a coasting body loses a metre; limbs are held by a force for each metre of
    limb inside and each metre a second:

    .. math::
        \frac{dv}{dx} = -\lambda v \;\Rightarrow\; F = m \lambda v^2, \qquad F = c L v
        \quad\Rightarrow\quad c = w \, \frac{m \lambda v_0}{L(h)}

    so that both laws hold the standing robot alike at one speed: m its mass, lambda the world's drag, v_0
    `REFERENCE_MPS`, h how high the cover is, L how much of a standing robot's limbs is below that height
    (`standing_length_m`), and w 1 for ground and `WINDING` for leaves and beads.

    Tall grass has no such drag: limbs bend its stems, as many and as stiff as the world's mesh has them there
    (`stems.stem_rigidity_n`, `stems.bending_n`).

    Note:
        Leaves and beads that hang from above are taken to reach the ground.
    """

    def __init__(self, world: World) -> None:
        self._ground = world.ground
        items = tuple(item for item in world.obstacles.items if SURFACES[item.surface].drag_per_m > 0)
        self._leaves = Obstacles(tuple(item for item in items if item.surface != _GRASS))
        self._grass = Obstacles(tuple(item for item in items if item.surface == _GRASS))
        self._stems_n = stem_rigidity_n(world)
        self.origin_m = (-world.ground.half_side_m, -world.ground.half_side_m)
        self.cell_m = world.ground.cell_m
        self.heights_m = world.ground.heights_m

    def grip_at(self, x_m: Float64[Array, " n"], y_m: Float64[Array, " n"]) -> Grip:
        """Return how the world holds at places."""
        ground = self._ground
        of_ground = surface_values("drag_per_m")[ground.surface_at(x_m, y_m)].astype(np.float64)
        leaves, of_leaves = _over(self._leaves, x_m, y_m)
        grass, _ = _over(self._grass, x_m, y_m)
        cells = len(ground.surface)
        column, row = (
            np.clip(np.floor(at / ground.cell_m + cells / 2), 0, cells - 1).astype(np.int64) for at in (x_m, y_m)
        )
        stems = np.where(grass > 0.0, self._stems_n[row, column], 0.0)
        winds = of_leaves > of_ground
        share = np.maximum(of_ground, of_leaves)
        loose = np.where(share > 0.0, LOOSE_M, 0.0)
        cover = np.maximum(np.where(winds, leaves, loose), np.where(stems > 0.0, grass, 0.0))
        length = np.where(cover > 0.0, standing_length_m(cover), 1.0)
        friction, stiffness, damping = (
            ground.contact_at(x_m, y_m, quantity).astype(np.float64)
            for quantity in ("friction", "stiffness_npm", "damping_nspm")
        )
        drag = np.where(winds, WINDING, 1.0) * MASS_KG * share * REFERENCE_MPS / length
        return Grip(friction, stiffness, damping, drag, cover, stems)


def _over(
    plants: Obstacles, x_m: Float64[Array, " n"], y_m: Float64[Array, " n"]
) -> tuple[Float64[Array, " n"], Float64[Array, " n"]]:
    """Return how high the tallest plant at each place grows and the largest drag of one, 0 where there is none."""
    height, drag = np.zeros((2, *x_m.shape))
    for item in plants.items:
        reach = item.half_length_m + (item.half_width_m or 0.0)
        near = np.flatnonzero((np.abs(x_m - item.x_m) <= reach) & (np.abs(y_m - item.y_m) <= reach))
        inside = near[Obstacles((item,)).clearance(x_m[near], y_m[near]) < 0]
        height[inside] = np.maximum(height[inside], item.height_m)
        drag[inside] = np.maximum(drag[inside], SURFACES[item.surface].drag_per_m)
    return height, drag
