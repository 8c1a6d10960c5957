"""Rays against the triangles of a world, by Embree."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int32, UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.world.embree import EmbreeTree
from navtool.sim.world.mesh import TriangleMesh

STEP_M = 1e-3
"""A ray goes on this far behind what it passed through."""


class Hits(NamedTuple):
    """What rays meet first."""

    distance_m: Float32[Array, " n"]
    """Along the ray in lengths of its direction; infinite where it meets nothing."""
    triangle: Int32[Array, " n"]
    """Number of the triangle in the mesh; -1 where it meets nothing."""
    u: Float32[Array, " n"]
    """Share of the triangle's second vertex at the point that is met."""
    v: Float32[Array, " n"]
    """Share of its third vertex there."""


class RayScene:
    """A mesh that rays are cast against. Origins and directions are float32, as Embree works."""

    def __init__(self, mesh: TriangleMesh) -> None:
        self.surface: UInt8[Array, " t"] = mesh.surface
        """Number of each triangle's surface."""
        self.normals: Float32[Array, "t 3"] = mesh.normals()
        """Unit normal of each triangle."""
        self._tree = EmbreeTree(mesh.vertices, mesh.triangles)

    def cast(self, origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"]) -> Hits:
        """The first triangle that each ray meets, from either side.

        Args:
            origins: Where the rays begin, world frame.
            directions: Where they go; of any length above 0.
        """
        found = self._tree.first_met(origins, directions)
        distance = np.where(found.triangle < 0, np.float32(np.inf), found.distance)
        return Hits(distance, found.triangle, found.u, found.v)

    def cast_on(
        self, origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"], passed_m: Float32[Array, " n"]
    ) -> Hits:
        """The next triangle behind what rays have passed through, with distances from the rays' origins.

        Args:
            origins: Where the rays begin, world frame.
            directions: Where they go, of length 1.
            passed_m: Distance of what they have passed through.
        """
        skip = passed_m + np.float32(STEP_M)
        found = self.cast(origins + skip[:, None] * directions, directions)
        return found._replace(distance_m=found.distance_m + skip)

    def blocked(
        self, origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"], *, coherent: bool = True
    ) -> Bool[Array, " n"]:
        """Whether anything stands in the rays' way; faster than ``cast``.

        Args:
            origins: Where the rays begin, world frame.
            directions: Where they go; of any length above 0.
            coherent: Whether rays that follow each other go nearly the same way; it decides the speed alone.
        """
        return self._tree.blocked(origins, directions, coherent=coherent)
