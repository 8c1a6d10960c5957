"""How stiff the tall grass of a world is, by place, from its blades."""

import numpy as np
from jaxtyping import Float64
from scipy import ndimage

from navtool.pipeline.arrays import Array
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import surface_number
from navtool.sim.world.vegetation import BLADES_PER_M2

SLIP_RAD = 0.55
"""How far a limb bends a stem before it slips past: the angle of friction between leaves and rubber or paint, whose
coefficient is about 0.6."""
TUFT_M = 0.3
"""Stiffness is a mean over a square of this side: grass grows in tufts, and bent stems lean on their neighbours."""


def bending_n(stems_n: float, width_m: float, height_m: float) -> float:
    r"""Return the force in N with which a stand of stems resists a limb that moves through it.

    .. math::
        F = M b W, \qquad W = \frac{1}{2} P \delta = \frac{2}{3} \frac{E I \theta^2}{z}

    M stems a square metre, b the limb's width: so many stems does it meet a metre; W the work to bend one of them
    past, a cantilever of rigidity EI that is pushed at height z until its slope there is theta (``SLIP_RAD``; P z^2 =
    2 EI theta, delta = 2 z theta / 3). It does not give the work back: it slips off and swings out behind the limb.
    The force therefore does not depend on the speed.

    Args:
        stems_n: M E I, the stems' rigidity on a square metre.
        width_m: Of the limb.
        height_m: Above the ground at which it meets them; above 0.
    """
    return stems_n * width_m * 2.0 / 3.0 * SLIP_RAD**2 / height_m


def stem_rigidity_n(world: World) -> Float64[Array, "rows columns"]:
    r"""Return M E I of a world's tall grass by cell of its ground, in N; 0 where none grows.

    A stand of growing grass that is h high has

    .. math:: M E I = 319 \, h^{3.3}

    Reference: Kouwen 1988 and Temple 1987, from stands of grass and alfalfa up to 1 m high. Blades of the mesh stand
    for the stems of such a stand: with `BLADES_PER_M2` of them, each as high as it is, it is as stiff as that.

    Note:
        Real stands have more and thinner stems than the mesh has blades.
    """
    ground = world.ground
    cells = len(ground.surface)
    # three triangles a blade, the first with both ends of its root (`foliage.blades`)
    blades = world.mesh.triangles[world.mesh.surface == surface_number("tall_grass")].reshape(-1, 9)
    corners = world.mesh.vertices[blades].astype(np.float64)
    rigidity = 319.0 * np.ptp(corners[:, :, 2], axis=1) ** 3.3 / BLADES_PER_M2
    column, row = (
        np.floor(corners[:, :2, k].mean(axis=1) / ground.cell_m + cells / 2).astype(np.int64) for k in (0, 1)
    )
    there = (column >= 0) & (column < cells) & (row >= 0) & (row < cells)
    total = np.bincount(row[there] * cells + column[there], rigidity[there], cells * cells).reshape(cells, cells)
    side = round(TUFT_M / ground.cell_m) | 1
    spread = ndimage.uniform_filter(total, side, mode="constant") / ground.cell_m**2
    # the filter's running sums leave rounding errors behind where no blade is near
    return np.asarray(np.where(ndimage.maximum_filter(total, side) > 0.0, spread, 0.0))
