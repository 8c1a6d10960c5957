"""Triangles, each of one surface."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int32, UInt8

from navtool.pipeline.arrays import Array


class TriangleMesh(NamedTuple):
    """Triangles in the world frame, metres."""

    vertices: Float32[Array, "v 3"]
    triangles: Int32[Array, "t 3"]
    """Three vertices each, counter-clockwise seen from where the normal points."""
    surface: UInt8[Array, " t"]
    """Number of each triangle's surface."""

    def normals(self) -> Float32[Array, "t 3"]:
        """The unit normal of each triangle; zero where it has no area."""
        a, b, c = (self.vertices[self.triangles[:, corner]] for corner in range(3))
        cross = np.cross(b - a, c - a)
        length = np.linalg.norm(cross, axis=1, keepdims=True)
        return np.asarray(cross / np.maximum(length, np.float32(1e-20)), np.float32)

    def areas(self) -> Float32[Array, " t"]:
        """The area of each triangle in square metres."""
        a, b, c = (self.vertices[self.triangles[:, corner]] for corner in range(3))
        return np.asarray(0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1), np.float32)

    def vertex_normals(self, chosen: Bool[Array, " t"]) -> Float32[Array, "v 3"]:
        """The mean normal of the chosen triangles about each vertex, weighted by their areas; zero where there is none.

        They are not of length 1.
        """
        index = np.flatnonzero(chosen)
        weighted = self.normals()[index] * self.areas()[index, None]
        total = np.zeros(self.vertices.shape, np.float32)
        for corner in self.triangles[index].T:
            for axis in range(3):
                total[:, axis] += np.bincount(corner, weighted[:, axis], len(total)).astype(np.float32)
        return total

    def moved(self, x: float, y: float, z: float) -> "TriangleMesh":
        """The same mesh elsewhere."""
        return self._replace(vertices=self.vertices + np.array([x, y, z], np.float32))


def make_mesh(vertices: Array, triangles: Array, surface: int) -> TriangleMesh:
    """A mesh of one surface from vertices (v, 3) and triangles (t, 3) of any real and whole number types."""
    corners = np.ascontiguousarray(triangles, np.int32).reshape(-1, 3)
    points = np.ascontiguousarray(vertices, np.float32).reshape(-1, 3)
    return TriangleMesh(points, corners, np.full(len(corners), surface, np.uint8))


def repeated_faces(faces: Sequence[Sequence[int]], corners: int, count: int) -> Int32[Array, "t 3"]:
    """The triangles of many equal bodies, one after another, with so many corners each."""
    pattern = np.array(faces, np.int32)
    first = corners * np.arange(count, dtype=np.int32)
    return np.asarray((first[:, None, None] + pattern).reshape(-1, 3))


def join_meshes(meshes: Sequence[TriangleMesh]) -> TriangleMesh:
    """All triangles in one mesh, in the order of the arguments."""
    if not meshes:
        return make_mesh(np.zeros((0, 3)), np.zeros((0, 3)), 0)
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes[:-1])])
    return TriangleMesh(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate([mesh.triangles + np.int32(start) for mesh, start in zip(meshes, starts, strict=True)]),
        np.concatenate([mesh.surface for mesh in meshes]),
    )
