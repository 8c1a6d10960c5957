"""Rocks, and what people have built: walls, pillars, panes of glass, bead curtains, rooms."""

import numpy as np

from navtool.pipeline.arrays import Array
from navtool.sim.world.mesh import TriangleMesh, join_meshes, make_mesh, repeated_faces
from navtool.sim.world.primitives import box, sphere_points, tube, turned
from navtool.sim.world.surfaces import surface_number

GLASS_THICKNESS_M = 0.012
STRING_SPACING_M = 0.028
"""Between the strings of a curtain, which are as wide as STRING_M and hang two deep."""
STRING_M = 0.007
CURTAIN_M = 2.1
"""Height of a curtain."""
_BEAD_M = 0.09
"""Length of the straight pieces of a string, each turned its own way."""


def rock_radius_m(size: float) -> float:
    """Radius of a boulder's outline, for a size of 0-1."""
    return 0.22 + 0.43 * size


def make_rock(size: float, rng: np.random.Generator) -> TriangleMesh:
    """A boulder, sunk into the ground at the origin: a sphere, squeezed, dented and cut flat in places."""
    points, faces = sphere_points(3)
    stretch = np.array([rng.uniform(0.8, 1.0), rng.uniform(0.7, 1.0), rng.uniform(0.5, 0.85)])
    shape: Array = np.ones(len(points))
    for _ in range(9):
        towards = rng.standard_normal(3)
        towards /= np.linalg.norm(towards)
        shape = np.minimum(shape, rng.uniform(0.72, 0.98) / np.maximum(points @ towards, 1e-3))
    for _ in range(3):
        waves = rng.normal(0.0, 3.0, 3)
        shape *= 1 + 0.03 * np.sin(points @ waves + rng.uniform(0, 6.3))
    body = points * shape[:, None] * stretch * rock_radius_m(size)
    body = turned(body, rng.uniform(0, 2 * np.pi)) + np.array([0.0, 0.0, 0.15 * rock_radius_m(size)])
    return make_mesh(body, faces, surface_number("rock"))


def make_curtain(half_length: float, yaw_rad: float, rng: np.random.Generator) -> TriangleMesh:
    """Strings of flat beads that hang from a rod over the origin, the strings side by side along x before the turn."""
    across = np.arange(-half_length + STRING_SPACING_M / 2, half_length, STRING_SPACING_M)
    pieces = round(CURTAIN_M / _BEAD_M)
    depth = np.where(np.arange(len(across)) % 2 == 0, -0.02, 0.02) + rng.normal(0.0, 0.004, len(across))
    string, piece = (index.ravel() for index in np.meshgrid(np.arange(len(across)), np.arange(pieces), indexing="ij"))
    twist = rng.uniform(0, np.pi, len(string))
    flat = 0.5 * STRING_M * np.column_stack([np.cos(twist), np.sin(twist), np.zeros(len(string))])
    top = np.column_stack([across[string], depth[string], CURTAIN_M - piece * _BEAD_M])
    bottom = top - np.array([0.0, 0.0, 0.92 * _BEAD_M])
    corners = np.stack([bottom - flat, bottom + flat, top + flat, top - flat], axis=1).reshape(-1, 3)
    faces = repeated_faces([[0, 1, 2], [0, 2, 3]], 4, len(string))
    rod = tube(np.array([[-half_length, 0.0, CURTAIN_M], [half_length, 0.0, CURTAIN_M]]), np.full(2, 0.012), 6, 0)
    steel = make_mesh(rod.vertices, rod.triangles, surface_number("steel"))
    mesh = join_meshes([make_mesh(corners, faces, surface_number("bead")), steel])
    return mesh._replace(vertices=turned(mesh.vertices.astype(np.float64), yaw_rad).astype(np.float32))


def make_pane(half_length: float, height: float, yaw_rad: float) -> TriangleMesh:
    """A pane of glass that stands on the origin: one sheet, so that a beam meets it once."""
    corners = np.array([[-half_length, 0, 0], [half_length, 0, 0], [half_length, 0, height], [-half_length, 0, height]])
    return make_mesh(turned(corners, yaw_rad), np.array([[0, 1, 2], [0, 2, 3]]), surface_number("glass"))


def make_pole(radius: float, height: float, surface: str) -> TriangleMesh:
    """A round pillar or pole that stands on the origin."""
    path = np.array([[0.0, 0.0, -0.1], [0.0, 0.0, height]])
    return tube(path, np.full(2, radius), 20, surface_number(surface))


def make_wall(half_length: float, half_width: float, height: float, yaw_rad: float, surface: str) -> TriangleMesh:
    """A wall that stands on the origin, its foot a little below the ground."""
    return box(half_length, half_width, height + 0.15, yaw_rad, surface_number(surface)).moved(0.0, 0.0, -0.15)


def make_ceiling(half_length: float, half_width: float, height: float) -> TriangleMesh:
    """A ceiling over the origin."""
    slab = box(half_length, half_width, 0.1, 0.0, surface_number("plaster"))
    return slab.moved(0.0, 0.0, height)
