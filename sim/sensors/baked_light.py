"""How much sun and sky each triangle of a world gets, cast once: the sun stands still during a drive."""

import cv2
import numpy as np
from jaxtyping import Float32, Int32

from navtool.pipeline.arrays import Array
from navtool.sim.sensors.lamps import Lamps
from navtool.sim.world.height_field import SKIRT_TRIANGLES
from navtool.sim.world.place import World
from navtool.sim.world.randomness import Purpose, generator
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.surfaces import surface_values

_TEXEL_M = 0.08
"""Texel of the ground's map of sunlight."""
_COARSE_M = 0.5
"""Texel of its map of skylight."""
_LIFT_M = np.float32(0.003)
_SKY_RAYS = 5
_ROW = 512
_GROUND_SKY_RAYS = 16
_INDOORS = np.float32(0.8)
"""Share of a room's scattered light that reaches a place in it."""
_LAMP_RAYS = 6


class BakedLight:
    """Light that reaches the surfaces of a world."""

    def __init__(self, world: World, scene: RayScene) -> None:
        self._scene, self._world = scene, world
        self._sun = np.array(world.sun, np.float32)
        side = world.ground.cell_m * len(world.ground.surface)
        self._half_side_m = np.float32(side / 2)
        self.ground_triangles = 2 * world.ground.surface.size + SKIRT_TRIANGLES
        """The first so many triangles of the mesh are ground."""
        self._lamps = None if world.config.room is None else Lamps(world.config.room)
        rng = generator(world.config.name, world.seed, Purpose.SHADE)
        self._thing_sun, self._thing_sky = self._bake_things(rng)
        self._ground = self._bake_ground(rng)

    def on_ground(self, x: Float32[Array, " n"], y: Float32[Array, " n"]) -> Float32[Array, "4 n"]:
        """Slopes along x and y; how much of the sun (in a room: of the lamps) and of the sky reaches the ground."""
        count = len(x)
        rows = max(-(-count // _ROW), 1)
        scale = np.float32(len(self._ground)) / (2 * self._half_side_m)
        place = np.zeros((2, rows * _ROW), np.float32)
        np.multiply(np.stack([x, y]) + self._half_side_m, scale, out=place[:, :count])
        column, row = (place - np.float32(0.5)).reshape(2, rows, _ROW)
        found = cv2.remap(self._ground, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.ascontiguousarray(found.reshape(-1, 4)[:count].T)

    def sun_on_things(self, triangle: Int32[Array, " n"]) -> Float32[Array, " n"]:
        """Whether triangles that stand on the ground see the sun."""
        return np.asarray(self._thing_sun[triangle - self.ground_triangles])

    def sky_on_things(self, triangle: Int32[Array, " n"]) -> Float32[Array, " n"]:
        """Share of the sky that such triangles see from their brighter side, 0-1."""
        return np.asarray(self._thing_sky[triangle - self.ground_triangles])

    def lamps_on_things(self, points: Float32[Array, "3 n"], normals: Float32[Array, "3 n"]) -> Float32[Array, " n"]:
        """The lamps' light on things, relative to its mean on the floor; other things' shadows are not on them."""
        return np.zeros(points.shape[1], np.float32) if self._lamps is None else self._lamps.unshaded(points, normals)

    def _bake_things(self, rng: np.random.Generator) -> tuple[Float32[Array, " t"], Float32[Array, " t"]]:
        corners = self._world.mesh.vertices[self._world.mesh.triangles[self.ground_triangles :]]
        centre = corners.mean(axis=1)
        count = len(centre)
        if self._world.config.room is not None:
            return np.zeros(count, np.float32), np.full(count, _INDOORS)
        seen = np.zeros(count, np.float32)
        for _ in range(_SKY_RAYS):
            towards = _upwards(rng, count)
            seen += ~self._scene.blocked(centre + 4 * _LIFT_M * towards, towards, coherent=False)
        seen /= _SKY_RAYS
        if self._world.config.light.sun_share == 0:
            return np.zeros(count, np.float32), seen
        towards = np.broadcast_to(self._sun, centre.shape)
        lit = ~self._scene.blocked(centre + 4 * _LIFT_M * towards, np.ascontiguousarray(towards))
        return lit.astype(np.float32), seen

    def _bake_ground(self, rng: np.random.Generator) -> Float32[Array, "h w 4"]:
        """Slopes, sunlight and skylight of the ground, softened by a few centimetres."""
        points = self._ground_points(_TEXEL_M)
        side = round(len(points) ** 0.5)
        normal = self._world.ground.normal_at(points[:, 0].astype(np.float64), points[:, 1].astype(np.float64))
        found = np.zeros((side, side, 4), np.float32)
        found[:, :, :2] = (-normal[:, :2] / normal[:, 2:]).reshape(side, side, 2)
        if self._lamps is not None:
            found[:, :, 2] = self._lamps_on_floor(points, self._lamps, rng).reshape(side, side)
            found[:, :, 3] = _INDOORS
            return np.asarray(cv2.GaussianBlur(found, (0, 0), 1.0))
        coarse = self._ground_points(_COARSE_M)
        sky: Array = np.zeros(len(coarse), np.float32)
        for _ in range(_GROUND_SKY_RAYS):
            towards = _upwards(rng, len(coarse))
            sky += ~self._scene.blocked(coarse + 4 * _LIFT_M * towards, towards, coherent=False)
        few = round(len(coarse) ** 0.5)
        sky = cv2.GaussianBlur((sky / _GROUND_SKY_RAYS).reshape(few, few), (0, 0), 0.7)
        found[:, :, 3] = cv2.resize(sky, (side, side), interpolation=cv2.INTER_LINEAR)
        if self._world.config.light.sun_share > 0:
            towards = np.ascontiguousarray(np.broadcast_to(self._sun, points.shape))
            lit = ~self._scene.blocked(points + 4 * _LIFT_M * towards, towards)
            found[:, :, 2] = lit.reshape(side, side)
        return np.asarray(cv2.GaussianBlur(found, (0, 0), 0.7))

    def _lamps_on_floor(
        self, points: Float32[Array, "n 3"], lamps: Lamps, rng: np.random.Generator
    ) -> Float32[Array, " n"]:
        """The lamps' light on the floor of the room with the shadows of what stands there; none outside."""
        room = self._world.config.room
        found = np.zeros(len(points), np.float32)
        if room is None:
            return found
        inside = np.flatnonzero((2 * abs(points[:, 0]) < room.length_m) & (2 * abs(points[:, 1]) < room.width_m))
        floor = np.ascontiguousarray(points[inside])
        up = np.zeros((3, len(floor)), np.float32)
        up[2] = 1
        clear = surface_values("transmittance") > 0
        for _ in range(_LAMP_RAYS):
            for place in lamps.within_panels(rng):
                towards = place - floor
                hits = self._scene.cast(floor + _LIFT_M * towards, towards)
                seen = (hits.distance_m > np.float32(0.97)) | clear[self._scene.surface[hits.triangle]]
                found[inside] += seen * lamps.light_of(place, floor.T, up)
        return found / np.float32(_LAMP_RAYS)

    def _ground_points(self, spacing_m: float) -> Float32[Array, "n 3"]:
        count = round(2 * float(self._half_side_m) / spacing_m)
        axis = (np.arange(count) + 0.5) * (2 * float(self._half_side_m) / count) - float(self._half_side_m)
        x, y = (values.ravel() for values in np.meshgrid(axis, axis))
        z = self._world.ground.height_at(x, y)
        return np.stack([x, y, z + float(_LIFT_M)], axis=-1).astype(np.float32)


def _upwards(rng: np.random.Generator, count: int) -> Float32[Array, "n 3"]:
    """Directions into the upper half space, as even a sky lights level ground: more of them steep than shallow."""
    angle = rng.uniform(0, 2 * np.pi, count)
    flat = np.sqrt(rng.random(count))
    return np.stack([flat * np.cos(angle), flat * np.sin(angle), np.sqrt(1 - flat**2)], axis=-1).astype(np.float32)
