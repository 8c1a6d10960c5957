"""Meshes of simple bodies."""

from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int

from navtool.pipeline.arrays import Array
from navtool.sim.world.mesh import TriangleMesh, make_mesh

_BOX_CORNERS = np.array([[x, y, z] for z in (0.0, 1.0) for y in (-1.0, 1.0) for x in (-1.0, 1.0)])
_BOX_SIDES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))
_BOX_FACES = np.array([face for a, b, c, d in _BOX_SIDES for face in ((a, b, c), (a, c, d))])


def box(half_length: float, half_width: float, height: float, yaw_rad: float, surface: int) -> TriangleMesh:
    """A box that stands on the origin, its length along x before it is turned about the vertical."""
    corners = _BOX_CORNERS * np.array([half_length, half_width, height])
    return make_mesh(turned(corners, yaw_rad), _BOX_FACES, surface)


def turned(points: Float[Array, "n 3"], yaw_rad: float) -> Float[Array, "n 3"]:
    """Points turned about the vertical axis through the origin."""
    cos, sin = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.asarray(points @ np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]))


def tube(path: Float[Array, "n 3"], radius_m: Float[Array, " n"], sides: int, surface: int) -> TriangleMesh:
    """A tube along a path of at least two points, closed at its end."""
    along = np.gradient(path, axis=0)
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    reference = np.array([1.0, 0.0, 0.0]) if abs(along[0, 0]) < 0.8 else np.array([0.0, 1.0, 0.0])
    u = np.cross(along, reference)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(along, u)
    angle = np.arange(sides) * (2 * np.pi / sides)
    ring = u[:, None] * np.cos(angle)[None, :, None] + v[:, None] * np.sin(angle)[None, :, None]
    rim = (path[:, None] + radius_m[:, None, None] * ring).reshape(-1, 3)
    segment, side = np.meshgrid(np.arange(len(path) - 1), np.arange(sides), indexing="ij")
    a = (segment * sides + side).ravel()
    b = (segment * sides + (side + 1) % sides).ravel()
    faces = [np.stack([a, b, b + sides], axis=1), np.stack([a, b + sides, a + sides], axis=1)]
    last = (len(path) - 1) * sides + np.arange(sides)
    cap = np.stack([last, np.roll(last, -1), np.full(sides, len(rim))], axis=1)
    return make_mesh(np.concatenate([rim, path[-1:]]), np.concatenate([*faces, cap]), surface)


@lru_cache(maxsize=4)
def sphere_points(subdivisions: int) -> tuple[Float[Array, "v 3"], Int[Array, "t 3"]]:
    """Vertices and triangles of the unit sphere: an icosahedron, each triangle split in four so many times."""
    golden = (1 + 5**0.5) / 2
    points = np.array([[s, t * golden, 0.0] for s in (-1, 1) for t in (-1, 1)])
    vertices = np.concatenate([points, points[:, [2, 0, 1]], points[:, [1, 2, 0]]])
    vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
    distance = np.linalg.norm(vertices[:, None] - vertices[None], axis=-1)
    near = (distance > 1e-9) & (distance < 1.2)
    faces = [
        (i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]
    ]
    triangles = np.array(faces)
    for _ in range(subdivisions):
        vertices, triangles = _split(vertices, triangles)
    a, b, c = (vertices[triangles[:, corner]] for corner in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), a + b + c) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return vertices, triangles


def _split(vertices: Float[Array, "v 3"], triangles: Int[Array, "t 3"]) -> tuple[Array, Array]:
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    unique, inverse = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    ab, bc, ca = np.split(inverse.ravel() + len(vertices), 3)
    a, b, c = triangles.T
    parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    return np.concatenate([vertices, middle]), np.concatenate([np.stack(part, axis=1) for part in parts])
