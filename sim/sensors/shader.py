"""The light that comes along rays in a world: what they meet, lit by sun and sky, or by the lamps of a room.

Vectors are stored component by component, [3, n]: NumPy is several times faster along the long axis.
"""

from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int, Int32, UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.sensors.baked_light import BakedLight
from navtool.sim.sensors.sky import Sky, sky_light
from navtool.sim.sensors.textures import TILE_M, TILE_PX, texture_bank
from navtool.sim.world.place import World
from navtool.sim.world.ray_scene import Hits, RayScene
from navtool.sim.world.surfaces import SURFACES, surface_number, surface_values

SKY = 255
"""Number of the sky, where a pixel's surface is asked for."""
_SUN_COLOUR = np.array([1.08, 1.0, 0.86], np.float32)
_SKY_COLOUR = np.array([0.86, 0.97, 1.22], np.float32)
_LAMP_COLOUR = np.array([1.03, 1.0, 0.93], np.float32)
_SCATTERED = np.float32(0.4)
"""Share of a room's light that walls and ceiling have scattered."""
_HAZE_PER_M = np.float32(1 / 260)
"""Share of the light that turns into haze in each metre on a clear day."""
_DRY = {
    "grass": (0.19, 0.165, 0.075),
    "mulch": (0.25, 0.16, 0.10),
    "sand": (0.56, 0.47, 0.34),
    "mud": (0.16, 0.125, 0.085),
}
"""Second colour of some grounds, which takes turns with the first in patches of a few metres."""
_PATCH_M = np.float32(2.3)
_SETS = {
    "small": ("leaf", "bush_leaf", "tall_grass", "bead", "twig"),
    "translucent": ("leaf", "bush_leaf", "tall_grass"),
    "blades": ("tall_grass",),
    "round": ("bark", "rock"),
    "large": ("concrete", "rock", "brick", "plaster", "steel", "bark"),
}
"""Small triangles, each of its own shade; those that glow against the sun; those of three triangles a piece; bodies
with smooth normals; things whose triangles are larger than shadows are, so that each pixel asks for the sun itself."""
_PANE = np.float32(0.05)
"""Share of the light that a pane mirrors when looked at straight on."""
_ROOM = np.float32(0.3)
"""Light of a room in a mirror."""
_SHADE = np.float32(0.12)
"""Share of the skylight that reaches even what sees no sky at all, from its surroundings."""


class Seen(NamedTuple):
    """What rays show."""

    radiance: Float32[Array, "3 n"]
    """Red, green and blue, relative to a white sheet on open level ground."""
    depth: Float32[Array, " n"]
    """In lengths of the rays; infinite for the sky."""
    surface: UInt8[Array, " n"]
    """Number of the surface; ``SKY`` for the sky."""
    triangle: Int32[Array, " n"]
    """Number of the triangle; -1 for the sky."""


class Shader:
    """Sees a world; what does not change from picture to picture is computed once."""

    def __init__(self, world: World, scene: RayScene) -> None:
        self._world, self._scene = world, scene
        self.light, self._bank = BakedLight(world, scene), texture_bank()
        place = f"{world.config.name}/{world.config.split.name}"
        self._sky = Sky(place, world.seed, world.sun, world.config.light)
        self._sun = np.array(world.sun, np.float32)
        self._indoors = world.config.room is not None
        share = world.config.light.sun_share
        self._sun_strength = (np.float32(share / world.sun[2]) * _SUN_COLOUR).astype(np.float32)
        self._sky_strength = np.float32(1 - share) * (_SKY_COLOUR if share > 0 else np.ones(3, np.float32))
        if self._indoors:
            self._sun_strength = (1 - _SCATTERED) * _LAMP_COLOUR
            self._sky_strength = _SCATTERED * np.ones(3, np.float32)
        self._colour = np.array([surface.colour for surface in SURFACES], np.float32).T.copy()
        self._dry = np.array([_DRY.get(surface.name, surface.colour) for surface in SURFACES], np.float32).T.copy()
        self._haze_per_m = _HAZE_PER_M + np.float32(world.config.weather.dust_per_m)
        self._is = {key: np.array([surface.name in names for surface in SURFACES]) for key, names in _SETS.items()}
        self.small: Bool[Array, " surfaces"] = self._is["small"]
        """Surfaces of which a pixel often sees only part, by number."""
        self._clear: Bool[Array, " 256"] = np.zeros(256, bool)
        self._clear[: len(SURFACES)] = surface_values("transmittance") > 0
        start = surface_number("twig") * TILE_PX**2
        blotches = self._bank.values[start : start + TILE_PX**2]
        self._dryness = np.clip((blotches - np.float32(0.85)) * np.float32(1.3), 0, 1)
        self._normals = np.ascontiguousarray(scene.normals.T)
        self._ragged = _near_edges(world.ground.surface)
        self._vertex_normals = world.mesh.vertex_normals(self._is["round"][world.mesh.surface]).T.copy()

    def see(self, eye: Float32[Array, "3"], rays: Float32[Array, "3 n"], pixel_rad: float) -> Seen:
        """What rays from one point show.

        Args:
            eye: Where they begin, world frame.
            rays: Directions, of any length.
            pixel_rad: Angle between neighbouring rays: how fine a texture they resolve.
        """
        origins = np.broadcast_to(eye, (rays.shape[1], 3))
        directions = rays.T
        hits = self._scene.cast(origins, directions)
        surface = self._surfaces(hits)
        radiance = np.zeros(rays.shape, np.float32)
        pane = np.flatnonzero(self._clear[surface])
        if pane.size:
            beyond = self._scene.cast_on(origins[pane], directions[pane], hits.distance_m[pane])
            through = np.zeros((3, pane.size), np.float32)
            self._paint(through, eye, rays[:, pane], beyond, self._surfaces(beyond), pixel_rad)
            radiance[:, pane] = self._with_glint(through, rays[:, pane], self._normals[:, hits.triangle[pane]])
        self._paint(radiance, eye, rays, hits, surface, pixel_rad)
        return Seen(radiance, hits.distance_m, surface, hits.triangle)

    def _surfaces(self, hits: Hits) -> UInt8[Array, " n"]:
        return np.where(hits.triangle >= 0, self._scene.surface[hits.triangle], np.uint8(SKY))

    def _paint(
        self,
        radiance: Float32[Array, "3 n"],
        eye: Float32[Array, "3"],
        rays: Float32[Array, "3 n"],
        hits: Hits,
        surface: UInt8[Array, " n"],
        pixel_rad: float,
    ) -> None:
        """Enter what rays show, but for panes: the sky, or a surface; where grounds meet, also which one shows."""
        sky = np.flatnonzero(surface == SKY)
        if sky.size and not self._indoors:
            radiance[:, sky] = self._sky.radiance(np.take(rays, sky, axis=1))
        solid = np.flatnonzero(~self._clear[surface] & (surface != SKY))
        shown = surface[solid].astype(np.int32)
        light = self._shade(eye, np.take(rays, solid, axis=1), hits, solid, shown, pixel_rad)
        for channel in range(3):
            radiance[channel, solid] = light[channel]
        surface[solid] = shown

    def _shade(
        self,
        eye: Float32[Array, "3"],
        rays: Float32[Array, "3 k"],
        hits: Hits,
        solid: Int[Array, " k"],
        surface: Int32[Array, " k"],
        pixel_rad: float,
    ) -> Float32[Array, "3 k"]:
        """The light of surfaces that let none through; ``solid`` names their hits, ``surface`` is blended in place."""
        distance, triangle = hits.distance_m[solid], hits.triangle[solid]
        points = eye[:, None] + distance * rays
        ground = triangle < self.light.ground_triangles
        on, off = np.flatnonzero(ground), np.flatnonzero(~ground)
        floor, things = np.take(points, on, axis=1), np.take(points, off, axis=1)
        under = self.light.on_ground(floor[0], floor[1])
        self._blend_edges(surface, on, floor)
        normal_up = np.empty(len(distance), np.float32)
        normals = self._thing_normals(hits, solid[off], surface[off], np.take(rays, off, axis=1))
        steepness = np.float32(1) / np.sqrt(1 + under[0] * under[0] + under[1] * under[1])
        normal_up[on], normal_up[off] = steepness, normals[2]
        reach = distance * np.sqrt(_dot(rays, rays))
        light = self._albedo(surface, triangle, points, normals, on, off, reach * np.float32(pixel_rad))
        sky: Array = np.empty(len(reach), np.float32)
        sun: Array = np.zeros(len(reach), np.float32)
        sky[on], sky[off] = under[3], self.light.sky_on_things(triangle[off])
        sky = sky_light(normal_up, _SHADE + (1 - _SHADE) * sky, indoors=self._indoors)
        if self._indoors:
            sun[on], sun[off] = under[2], self.light.lamps_on_things(things, normals)
        elif self._world.config.light.sun_share > 0:
            facing = (self._sun[2] - under[0] * self._sun[0] - under[1] * self._sun[1]) * steepness
            sun[on] = under[2] * np.maximum(facing, 0)
            sun[off] = self._sun_on_things(things, normals, triangle[off], surface[off])
        haze = None if self._indoors else 1 - np.exp(-reach * self._haze_per_m)
        for channel in range(3):
            light[channel] *= sky * self._sky_strength[channel] + sun * self._sun_strength[channel]
            if haze is not None:
                light[channel] += (self._sky.horizon[channel] - light[channel]) * haze
        return light

    def _blend_edges(self, surface: Int32[Array, " k"], on: Int[Array, " g"], floor: Float32[Array, "3 g"]) -> None:
        """Let grounds pass into each other along ragged lines, not along the edges of the cells."""
        near = np.flatnonzero(self._ragged[self._cell(floor[1]), self._cell(floor[0])])
        x, y = floor[0, near], floor[1, near]
        coarse = np.full(near.size, surface_number("twig"), np.int32)
        fine = np.zeros(near.size, np.float32)
        reach = np.float32(1.6 * self._world.ground.cell_m)
        across = reach * (self._bank.look_up(coarse, x, y, fine) - 1)
        along = reach * (self._bank.look_up(coarse, y + np.float32(0.7), x, fine) - 1)
        surface[on[near]] = self._world.ground.surface[self._cell(y + along), self._cell(x + across)]

    def _cell(self, position_m: Float32[Array, " n"]) -> Int32[Array, " n"]:
        """The row or column of the ground's cell at a position; beyond the edge that of the edge."""
        last = len(self._ragged) - 1
        place = (position_m + np.float32(self._world.ground.half_side_m)) * np.float32(1 / self._world.ground.cell_m)
        return np.clip(place, 0, last).astype(np.int32)

    def _thing_normals(
        self, hits: Hits, index: Int[Array, " t"], surface: Int32[Array, " t"], rays: Float32[Array, "3 t"]
    ) -> Float32[Array, "3 t"]:
        """Normals towards the eye: smooth ones of what is round, those of the triangles elsewhere."""
        normals = np.take(self._normals, hits.triangle[index], axis=1)
        rounded = np.flatnonzero(self._is["round"][surface])
        if rounded.size:
            at = index[rounded]
            corners = self._world.mesh.triangles[hits.triangle[at]].T
            a, b, c = (np.take(self._vertex_normals, corner, axis=1) for corner in corners)
            u, v = hits.u[at], hits.v[at]
            normals[:, rounded] = _unit((1 - u - v) * a + u * b + v * c)
        normals *= np.where(_dot(normals, rays) > 0, np.float32(-1), np.float32(1))
        return normals

    def _albedo(
        self,
        surface: Int32[Array, " n"],
        triangle: Int32[Array, " n"],
        points: Float32[Array, "3 n"],
        normals: Float32[Array, "3 t"],
        on: Int[Array, " g"],
        off: Int[Array, " t"],
        footprint_m: Float32[Array, " n"],
    ) -> Float32[Array, "3 n"]:
        """Colour and texture at points; ``on`` names those on the ground, ``off`` the others."""
        x, y, z = points
        across, up = x.copy(), y.copy()
        steep = np.abs(normals[2]) < np.float32(0.7)
        up[off[steep]] = z[off[steep]]
        turned = off[steep & (np.abs(normals[0]) > np.abs(normals[1]))]
        across[turned] = y[turned]
        shade = self._bank.look_up(surface, across, up, footprint_m)
        colour = np.take(self._colour, surface, axis=1)
        kind = surface[on]
        dry = self._patches(x[on], y[on])
        for channel in range(3):
            colour[channel, on] += dry * (self._dry[channel] - self._colour[channel])[kind]
        own = off[self.small[surface[off]]]
        body = (triangle[own] // np.where(self._is["blades"][surface[own]], 3, 1)).astype(np.uint32)
        mixed = body * np.uint32(2654435761)
        shade[own] *= np.float32(0.65) + (mixed >> 24).astype(np.float32) * np.float32(0.7 / 255)
        hue = ((mixed >> 16) & 255).astype(np.float32) * np.float32(1 / 255) - np.float32(0.5)
        colour[:, own] *= 1 + hue * np.array([[0.7], [0.15], [-0.3]], np.float32)
        colour *= shade
        return colour

    def _patches(self, x: Float32[Array, " n"], y: Float32[Array, " n"]) -> Float32[Array, " n"]:
        """How much of its second colour the ground shows, 0-1, in patches of a few metres."""
        scale = np.float32(TILE_PX / TILE_M) / _PATCH_M
        column = np.floor(x * scale).astype(np.int32) & (TILE_PX - 1)
        row = np.floor(y * scale).astype(np.int32) & (TILE_PX - 1)
        return np.asarray(self._dryness[row * TILE_PX + column])

    def _sun_on_things(
        self,
        points: Float32[Array, "3 n"],
        normals: Float32[Array, "3 n"],
        triangle: Int32[Array, " n"],
        surface: Int32[Array, " n"],
    ) -> Float32[Array, " n"]:
        """Sunlight on what stands on the ground, relative to a sheet that faces the sun; leaves glow against it."""
        cosine = self._sun @ normals
        through = np.where(self._is["translucent"][surface], np.float32(0.5), np.float32(0))
        sun = np.where(cosine > 0, cosine, -through * cosine)
        large = self._is["large"][surface]
        sun[~large] *= self.light.sun_on_things(triangle[~large])
        asked = np.flatnonzero(large & (sun > 0))
        start = points[:, asked] + np.float32(0.01) * (normals[:, asked] + self._sun[:, None])
        towards = np.broadcast_to(self._sun, (asked.size, 3))
        sun[asked] *= ~self._scene.blocked(start.T, towards)
        return sun

    def _with_glint(
        self, through: Float32[Array, "3 n"], rays: Float32[Array, "3 n"], normals: Float32[Array, "3 n"]
    ) -> Float32[Array, "3 n"]:
        """What is seen through a pane, and over it what the pane mirrors."""
        along = _dot(normals, rays)
        share = _PANE + (1 - _PANE) * (1 - np.abs(along) / np.sqrt(_dot(rays, rays))) ** 5
        glint: Array = np.full(through.shape, _ROOM)
        if not self._indoors:
            glint = self._sky.radiance(rays - 2 * along * normals)
        return np.asarray(np.float32(0.9) * (1 - share) * through + share * glint)


def _near_edges(surface: UInt8[Array, "n n"]) -> Bool[Array, "n n"]:
    """Whether a cell has a neighbour of another surface within two cells."""
    square = np.ones((5, 5), np.uint8)
    return np.asarray(cv2.dilate(surface, square) != cv2.erode(surface, square))


def _dot(a: Float32[Array, "3 n"], b: Float32[Array, "3 n"]) -> Float32[Array, " n"]:
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def _unit(vectors: Float32[Array, "3 n"]) -> Float32[Array, "3 n"]:
    """Vectors of length 1; those without length stay so."""
    return np.asarray(vectors / np.maximum(np.sqrt(_dot(vectors, vectors)), np.float32(1e-6)))
