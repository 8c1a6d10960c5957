"""Bushes that stop a robot, and tall grass that yields to it."""

import numpy as np

from navtool.sim.world.foliage import blades, leaves
from navtool.sim.world.mesh import TriangleMesh, join_meshes
from navtool.sim.world.primitives import tube
from navtool.sim.world.surfaces import surface_number

BUSH_LEAVES_PER_M3 = 1300.0
"""Leaves of 0.0021 square metres each: 2.7 square metres of leaf a cubic metre, most of it near the outline."""
BLADES_PER_M2 = 115.0
"""Blades of 5 mm in random directions: a beam passes 2.7 m of them on average before it meets one."""
BLADE_M = 0.005
_TUFT_M = 0.07
_BLADES_PER_TUFT = 8


def bush_radius_m(size: float) -> float:
    """Radius of a bush's outline, for a size of 0-1."""
    return 0.45 + 0.45 * size


def bush_height_m(size: float) -> float:
    """Height of a bush, for a size of 0-1."""
    return 0.6 + 0.6 * size


def patch_radius_m(size: float) -> float:
    """Radius of a patch of tall grass, for a size of 0-1."""
    return 0.7 + 1.5 * size


def make_bush(size: float, rng: np.random.Generator) -> TriangleMesh:
    """A bush that stands on the origin: stems, and leaves that are densest towards its outline."""
    radius, height = bush_radius_m(size), bush_height_m(size)
    count = round(BUSH_LEAVES_PER_M3 * 2 / 3 * np.pi * radius**2 * height)
    ray = rng.standard_normal((count, 3))
    ray[:, 2] = np.abs(ray[:, 2])
    lumps = 0.88 + 0.12 * np.sin(3 * np.arctan2(ray[:, 1], ray[:, 0]) + rng.uniform(0, 6.3))
    ray *= (rng.random(count) ** (1 / 5) * lumps / np.linalg.norm(ray, axis=1))[:, None]
    centres = ray * np.array([radius, radius, height])
    length = rng.uniform(0.055, 0.085, count)
    parts = [leaves(centres, length, 0.85, surface_number("bush_leaf"), rng)]
    for _ in range(int(rng.integers(8, 13))):
        tip = centres[rng.integers(0, count)] * 0.9
        path = np.linspace(0, 1, 4)[:, None] * tip + np.array([0.0, 0.0, -0.05])
        path[1:3] += rng.normal(0.0, 0.03, (2, 3))
        parts.append(tube(path, np.linspace(0.012, 0.004, 4), 3, surface_number("twig")))
    return join_meshes(parts)


def make_grass_patch(size: float, rng: np.random.Generator) -> TriangleMesh:
    """A patch of tall grass about the origin: tufts of blades, highest in its middle."""
    radius = patch_radius_m(size)
    tufts = max(1, round(BLADES_PER_M2 / _BLADES_PER_TUFT * np.pi * radius**2))
    angle, reach = rng.uniform(0, 2 * np.pi, tufts), np.sqrt(rng.random(tufts))
    ragged = 0.9 + 0.1 * np.sin(5 * angle + rng.uniform(0, 6.3))
    middle = (radius * ragged * reach)[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    feet = np.repeat(middle, _BLADES_PER_TUFT, axis=0)
    feet = feet + rng.normal(0.0, _TUFT_M, feet.shape)
    tallest = rng.uniform(0.6, 1.1)
    height = tallest * rng.uniform(0.55, 1.0, len(feet)) * (1.05 - 0.35 * np.repeat(reach, _BLADES_PER_TUFT) ** 2)
    root = np.column_stack([feet, np.full(len(feet), -0.03)])
    return blades(root, height, BLADE_M, surface_number("tall_grass"), rng)
