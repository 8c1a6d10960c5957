"""Trees: a trunk, branches, and a crown of single leaves; some with strands of leaves that hang low."""

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.sim.world.foliage import leaves
from navtool.sim.world.mesh import TriangleMesh, join_meshes
from navtool.sim.world.primitives import tube
from navtool.sim.world.surfaces import surface_number

LEAF_M = (0.10, 0.16)
"""Least and largest length of a leaf: each stands for a spray of real ones."""
LEAVES_PER_M3 = 220.0
"""In a crown: 1.1 square metres of leaf a cubic metre, a broad-leaved crown."""
_STRAND_STEP_M = 0.06


def trunk_radius_m(size: float) -> float:
    """Radius of the trunk at the ground, for a size of 0-1."""
    return 0.07 + 0.15 * size


def make_tree(size: float, rng: np.random.Generator, *, hanging: bool = False) -> TriangleMesh:
    """A tree that stands on the origin.

    Args:
        size: 0 for the smallest (3.5 m), 1 for the largest (7 m).
        rng: Source of its shape.
        hanging: Whether strands of leaves hang down to 0.3-1.0 m above the ground, as of a willow.
    """
    height = 3.5 + 3.5 * size
    trunk = _trunk(height, size, rng)
    crown_radius = (0.9 + 0.9 * size) * rng.uniform(0.9, 1.1)
    crown_half_height = 0.30 * height
    crown_centre = np.array([*trunk[-1, :2], height - crown_half_height])
    branches = _branches(trunk, crown_radius, rng)
    parts = [tube(trunk, np.linspace(trunk_radius_m(size), 0.03, len(trunk)), 9, surface_number("bark"))]
    parts += [tube(path, np.linspace(0.035, 0.008, len(path)), 4, surface_number("bark")) for path in branches]
    volume = 4 / 3 * np.pi * crown_radius**2 * crown_half_height
    centres = _crown(crown_centre, crown_radius, crown_half_height, branches, round(LEAVES_PER_M3 * volume), rng)
    parts.append(_leaves(centres, rng))
    if hanging:
        parts += _strands(crown_centre, crown_radius, crown_half_height, rng)
    return join_meshes(parts)


def _trunk(height: float, size: float, rng: np.random.Generator) -> Float[Array, "n 3"]:
    """The middle line of the trunk: it leans and wanders a little, and begins below the ground."""
    z = np.linspace(-0.15, 0.85 * height, 8)
    wander = np.cumsum(rng.normal(0.0, 0.02 + 0.02 * size, (8, 2)), axis=0)
    wander[:2] = 0.0
    return np.column_stack([wander, z])


def _branches(trunk: Float[Array, "n 3"], crown_radius: float, rng: np.random.Generator) -> list[Float[Array, "4 3"]]:
    """Branches that rise from the upper half of the trunk and reach into the crown."""
    paths = []
    for azimuth in rng.uniform(0, 2 * np.pi) + 2.4 * np.arange(rng.integers(7, 11)):
        share = rng.uniform(0.45, 0.95)
        root = np.array([np.interp(share, np.linspace(0, 1, len(trunk)), trunk[:, axis]) for axis in range(3)])
        length = crown_radius * rng.uniform(0.7, 1.0) * (1.25 - 0.6 * share)
        out = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        rise = rng.uniform(0.3, 0.9)
        steps = np.linspace(0, 1, 4)[:, None]
        path = root + length * (steps * out + rise * steps**0.7 * np.array([0.0, 0.0, 1.0]))
        path[1:3] += rng.normal(0.0, 0.04, (2, 3))
        paths.append(path)
    return paths


def _crown(
    centre: Float[Array, "3"],
    radius: float,
    half_height: float,
    branches: list[Float[Array, "4 3"]],
    count: int,
    rng: np.random.Generator,
) -> Float[Array, "n 3"]:
    """Where the leaves are: half of them in clusters about the branches, half within the crown's ellipsoid."""
    ends = np.concatenate([path[1:] for path in branches])
    clustered = ends[rng.integers(0, len(ends), count // 2)] + rng.normal(0.0, 0.28, (count // 2, 3))
    inside = rng.standard_normal((count - count // 2, 3))
    inside *= (rng.random(len(inside)) ** (1 / 3) / np.linalg.norm(inside, axis=1))[:, None]
    return np.concatenate([clustered, centre + inside * np.array([radius, radius, half_height])])


def _leaves(centres: Float[Array, "n 3"], rng: np.random.Generator) -> TriangleMesh:
    return leaves(centres, rng.uniform(*LEAF_M, len(centres)), 0.6, surface_number("leaf"), rng, upright=0.2)


def _strands(
    centre: Float[Array, "3"], radius: float, half_height: float, rng: np.random.Generator
) -> list[TriangleMesh]:
    """Thin twigs with leaves that hang from the rim of the crown."""
    parts, hung = [], []
    count = round(9 * radius**2 * rng.uniform(0.8, 1.2))
    for _ in range(count):
        azimuth, reach = rng.uniform(0, 2 * np.pi), radius * np.sqrt(rng.uniform(0.15, 1.2))
        x, y = centre[0] + reach * np.cos(azimuth), centre[1] + reach * np.sin(azimuth)
        top, bottom = centre[2] - 0.4 * half_height, rng.uniform(0.3, 1.0)
        if bottom > top - 0.3:
            continue
        z = np.linspace(top, bottom, 5)
        sway = np.cumsum(rng.normal(0.0, 0.04, (5, 2)), axis=0)
        path = np.column_stack([x + sway[:, 0], y + sway[:, 1], z])
        parts.append(tube(path, np.linspace(0.006, 0.003, 5), 3, surface_number("twig")))
        along = np.linspace(0, 4, max(2, round((top - bottom) / _STRAND_STEP_M)))
        points = np.column_stack([np.interp(along, np.arange(5), path[:, axis]) for axis in range(3)])
        hung.append(points + rng.normal(0.0, 0.035, points.shape))
    if hung:
        parts.append(_leaves(np.concatenate(hung), rng))
    return parts
