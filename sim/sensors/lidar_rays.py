"""The rays of a spinning LiDAR's turn, and what they meet."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int, UInt8
from scipy import ndimage

from navtool.pipeline.arrays import Array
from navtool.sim.sensors.lidar_config import LidarConfig
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.surface import returned_share
from navtool.sim.world.surfaces import SURFACES, surface_values

MIXED_M = 0.1
"""Parts of a beam that lie closer together in range need no look at the pulse: they add up."""
NOTHING_M = np.float32(1e9)
"""Range of a ray that meets nothing."""
_GLANCE_RAD = 0.05
"""A pane mirrors a beam back into the receiver within about this angle from its normal: it is never quite flat."""
_POROUS = ("twig", "leaf", "bush_leaf", "tall_grass", "bead")
"""What is smaller than a beam: another part of the beam may well go past it."""
_AROUND = np.ones((3, 5), bool)
"""Rings and columns around such a thing in which there may well be more of it."""


class BeamRays(NamedTuple):
    """What the rays of a turn meet, ring by ring along the azimuth: on the axis of each beam, and between two beams."""

    range_m: Float32[Array, "*rays"]
    """``NOTHING_M`` for nothing."""
    strength: Float32[Array, "*rays"]
    surface: UInt8[Array, "*rays"]
    behind_m: Float32[Array, "*rays"]
    """Range of what lies behind glass; this and what follows is empty where no ray of the turn went through glass."""
    behind_strength: Float32[Array, "*rays"]
    behind_surface: UInt8[Array, "*rays"]
    glass: Bool[Array, "*rays"]
    """Whether the ray went through glass."""


class RayCaster:
    """Casts the rays of a turn; what does not change from turn to turn is computed once.

    There is a ray on the axis of each beam, and one between it and the next. The rays between two beams are cast only
    where the two axes meet different things, or something that lets light past; elsewhere they lie on the surface
    between them.
    """

    def __init__(self, config: LidarConfig) -> None:
        self._rings, self._columns = config.rings, config.columns
        elevation, azimuth = np.array(config.elevation_rad)[:, None], config.azimuth_rad()
        self._axes = beam_directions(elevation, azimuth)
        tilt = np.where(np.arange(self._columns) % 2, 1, -1) * config.divergence_rad[1] / 3
        self._between = beam_directions(elevation + tilt, azimuth - config.column_rad / 2)
        self._reflectivity, self._roughness = surface_values("reflectivity"), surface_values("roughness_rad")
        self._transmittance, self._specular = surface_values("transmittance"), surface_values("specular")
        self._porous = np.array([surface.name in _POROUS for surface in SURFACES])

    def cast(self, scene: RayScene, world_lidar: Float[Array, "columns 4 4"]) -> BeamRays:
        """Send out the rays of a turn: all axes first, then what lies between them where it matters."""
        turn = world_lidar[:, :3, :3].transpose(1, 2, 0).astype(np.float32)
        place = world_lidar[:, :3, 3].astype(np.float32)
        shape = (self._rings, self._columns)
        origins = np.tile(place, (self._rings, 1))
        on_axis = self._sent(scene, origins, _turned(turn, self._axes))
        surface, reach = on_axis.surface.reshape(shape), on_axis.range_m.reshape(shape)
        loose = (self._porous[surface] & (reach < NOTHING_M)) | on_axis.glass.reshape(shape)
        apart = np.abs(np.diff(reach, axis=1, append=reach[:, -1:])) > np.float32(MIXED_M)
        apart |= ndimage.binary_dilation(loose, _AROUND)
        index = np.flatnonzero(apart)
        column = index % self._columns
        extra = self._sent(
            scene, place[column], _turned(turn[:, :, column], [part.ravel()[index] for part in self._between])
        )
        rays = []
        fields = 7 if on_axis.glass.any() or extra.glass.any() else 3
        for values, found in zip(on_axis[:fields], extra[:fields], strict=True):
            both = np.empty((*shape, 2), values.dtype)
            both[:, :, 0] = values.reshape(shape)
            both[:, :, 1] = both[:, :, 0]
            if values.dtype == np.float32:
                both[:, :-1, 1] = np.float32(0.5) * (both[:, :-1, 0] + both[:, 1:, 0])
            both.reshape(-1, 2)[index, 1] = found
            rays.append(both.reshape(shape[0], -1))
        return BeamRays(*rays, *(values[:0] for values in on_axis[fields:]))

    def _sent(self, scene: RayScene, origins: Float32[Array, "n 3"], directions: Float32[Array, "n 3"]) -> BeamRays:
        """What rays meet, and what those that meet glass find behind it; arrays are flat."""
        hits = scene.cast(origins, directions)
        reach, strength, surface = self._returned(scene, hits.distance_m, hits.triangle, directions)
        glass = (hits.triangle >= 0) & (self._transmittance[surface] > 0)
        behind = np.full(reach.shape, NOTHING_M)
        behind_strength, behind_surface = np.zeros_like(reach), np.zeros_like(surface)
        index = np.flatnonzero(glass)
        if index.size:
            passed = self._transmittance[surface[index]]
            beyond = scene.cast_on(origins[index], directions[index], reach[index])
            found = self._returned(scene, beyond.distance_m, beyond.triangle, directions[index])
            behind[index], behind_strength[index], behind_surface[index] = found[0], found[1] * passed**2, found[2]
        return BeamRays(reach, strength, surface, behind, behind_strength, behind_surface, glass)

    def _returned(
        self,
        scene: RayScene,
        distance: Float32[Array, " n"],
        triangle: Int[Array, " n"],
        directions: Float32[Array, "n 3"],
    ) -> tuple[Float32[Array, " n"], Float32[Array, " n"], UInt8[Array, " n"]]:
        """Range, strength and surface of what rays have met, as if each were a whole beam."""
        surface = scene.surface[triangle]
        normals = np.take(scene.normals, triangle, axis=0)
        cosine = normals[:, 0] * directions[:, 0]
        for axis in (1, 2):
            cosine += normals[:, axis] * directions[:, axis]
        np.abs(cosine, out=cosine)
        strength = returned_share(cosine, self._reflectivity[surface], self._roughness[surface])
        mirror = np.flatnonzero(self._specular[surface] > 0)
        angle = np.arccos(np.minimum(cosine[mirror], np.float32(1)))
        strength[mirror] += self._specular[surface[mirror]] * np.exp(np.float32(-0.5 / _GLANCE_RAD**2) * angle * angle)
        met = triangle >= 0
        strength[~met] = 0
        return np.where(met, distance, NOTHING_M), strength, surface


def beam_directions(
    elevation: Float[Array, "..."], azimuth: Float[Array, "rings n"]
) -> tuple[Float32[Array, "rings n"], Float32[Array, "rings n"], Float32[Array, "rings n"]]:
    """Unit vectors of beams, component by component."""
    flat = np.cos(elevation)
    x, y, z = np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation))
    return x.astype(np.float32), y.astype(np.float32), z.astype(np.float32)


def _turned(turn: Float32[Array, "3 3 columns"], rays: Sequence[Float32[Array, "..."]]) -> Float32[Array, "n 3"]:
    """Rays, component by component, in the world; one after another, ring by ring."""
    x, y, z = rays
    return np.stack([(row[0] * x + row[1] * y + row[2] * z).ravel() for row in turn]).T
