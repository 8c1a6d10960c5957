"""Many leaves or blades at once."""

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.sim.world.mesh import TriangleMesh, make_mesh, repeated_faces


def leaves(
    centres: Float[Array, "n 3"],
    length_m: Float[Array, " n"],
    width_share: float,
    surface: int,
    rng: np.random.Generator,
    *,
    upright: float = 0.0,
) -> TriangleMesh:
    """Flat leaves, one triangle each, as large as a leaf with two rounded sides: rays pass half as many triangles.

    Args:
        centres: Where they are.
        length_m: From tip to stalk.
        width_share: Width of its broad end over its length.
        surface: What they are made of.
        rng: Source of their directions.
        upright: 0 for leaves that face any way, towards 1 for leaves that lie ever flatter.
    """
    count = len(centres)
    normal = rng.standard_normal((count, 3))
    normal[:, 2] = np.abs(normal[:, 2]) + 2.5 * upright
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    along = np.cross(normal, rng.standard_normal((count, 3)))
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(normal, along) * (0.5 * width_share * length_m)[:, None]
    along *= 0.5 * length_m[:, None]
    corners = np.stack([centres - along + across, centres - along - across, centres + along], axis=1)
    return make_mesh(corners, repeated_faces([[0, 1, 2]], 3, count), surface)


def blades(
    feet: Float[Array, "n 3"],
    height_m: Float[Array, " n"],
    width_m: float,
    surface: int,
    rng: np.random.Generator,
) -> TriangleMesh:
    """Upright blades that taper and bend over at the tip, three triangles each."""
    count = len(feet)
    azimuth = rng.uniform(0, 2 * np.pi, count)
    lean_azimuth = rng.uniform(0, 2 * np.pi, count)
    lean = np.abs(rng.normal(0.0, 0.22, count))
    flat = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros(count)], axis=1)
    out = np.stack([np.cos(lean_azimuth), np.sin(lean_azimuth), np.zeros(count)], axis=1)
    up = np.array([0.0, 0.0, 1.0])
    middle = feet + 0.6 * height_m[:, None] * (up + 0.5 * lean[:, None] * out)
    tip = middle + 0.4 * height_m[:, None] * (up * np.cos(2 * lean)[:, None] + np.sin(2 * lean)[:, None] * out)
    side = 0.5 * width_m * flat
    corners = np.stack([feet - side, feet + side, middle - 0.8 * side, middle + 0.8 * side, tip], axis=1)
    return make_mesh(corners, repeated_faces([[0, 1, 3], [0, 3, 2], [2, 3, 4]], 5, count), surface)
