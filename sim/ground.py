"""The level ground of a place: terrain regions, their texture, roughness and reflectivity, and baked shadows."""

from dataclasses import dataclass
from enum import IntEnum

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int, UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.shapes import Shape

HALF_SIDE_M = 40.0
"""Half the side of the mapped square; beyond it the map repeats mirrored."""
TEXEL_M = 0.05
DETAIL_M = 0.01
"""Side of one texel of the fine texture that is laid over the coloured one near the camera."""


class Terrain(IntEnum):
    """What the ground is made of at a place."""

    GRASS = 0
    GRAVEL = 1
    PATH = 2


_COLOUR = np.array([[98, 116, 58], [136, 128, 116], [158, 134, 104]], np.float32)
_CONTRAST = np.array([0.85, 0.7, 0.25], np.float32)
ROUGHNESS = np.array([0.55, 1.0, 0.2])
"""Vibration per metre a second, per terrain, relative to gravel."""
REFLECTIVITY = np.array([0.4, 0.25, 0.3], np.float32)
RELIEF_M = np.array([0.03, 0.012, 0.004], np.float32)
"""Standard deviation of the height a laser beam finds, per terrain."""


@dataclass(frozen=True, slots=True)
class Ground:
    """The plane z = 0 with its terrain."""

    terrain: UInt8[Array, "n n"]
    """Terrain per texel, rows along y, columns along x."""
    colour: UInt8[Array, "n n 4"]
    """Linear RGB with shadows, and the contrast of the fine texture (255 = 1)."""
    detail: UInt8[Array, "m m"]
    """Fine texture, tiled; 128 is neutral."""

    def terrain_at(self, x: Float[Array, "..."], y: Float[Array, "..."]) -> Int[Array, "..."]:
        """Return the terrain at points in metres; beyond the map, that of its edge."""
        last = self.terrain.shape[0] - 1
        column = np.clip((x + HALF_SIDE_M) / TEXEL_M, 0, last).astype(np.int64)
        row = np.clip((y + HALF_SIDE_M) / TEXEL_M, 0, last).astype(np.int64)
        return self.terrain[row, column].astype(np.int64)


def smooth_noise(rng: np.random.Generator, side: int, cells: int) -> Float32[Array, "side side"]:
    """Return noise in [0, 1] with features of ``side / cells`` texels that continues over opposite edges."""
    grid = np.pad(rng.random((cells, cells), dtype=np.float32), 2, mode="wrap")
    step = side / cells
    axis = ((np.arange(side, dtype=np.float32) + 0.5) / step + 1.5).astype(np.float32)
    columns, rows = np.meshgrid(axis, axis)
    return np.clip(cv2.remap(grid, columns, rows, cv2.INTER_CUBIC), 0, 1)


def make_ground(rng: np.random.Generator, casters: list[tuple[Shape, bool]], sun: tuple[float, float, float]) -> Ground:
    """Draw terrain and texture, and bake the shadows of the bodies (shape, solid) into the colour."""
    side = round(2 * HALF_SIDE_M / TEXEL_M)
    terrain = np.full((side, side), Terrain.GRASS, np.uint8)
    terrain[smooth_noise(rng, side, 12) > 0.72] = Terrain.GRAVEL
    terrain[np.abs(smooth_noise(rng, side, 6) - 0.5) < 0.03] = Terrain.PATH
    tint = np.float32(0.5) + _octaves(rng, side, {20: 0.35, 100: 0.25, 400: 0.4})
    light = cv2.GaussianBlur(_shadows(rng, side, casters, sun), (0, 0), 1.0)
    colour = cv2.GaussianBlur(_COLOUR[terrain], (0, 0), 2.5) * (tint * light)[..., None]
    contrast = cv2.GaussianBlur(_CONTRAST[terrain], (0, 0), 2.5)[..., None] * 255
    texels = np.clip(np.concatenate([colour, contrast], axis=-1), 0, 255).astype(np.uint8)
    fine = 128 + 127 * (_octaves(rng, 512, {64: 0.6, 170: 0.8, 256: 0.6}) - np.float32(1.0))
    return Ground(terrain=terrain, colour=texels, detail=np.clip(fine, 0, 255).astype(np.uint8))


def _octaves(rng: np.random.Generator, side: int, weights: dict[int, float]) -> Float32[Array, "side side"]:
    """Return a weighted sum of smooth noises, by their number of cells."""
    total = np.zeros((side, side), np.float32)
    for cells, weight in weights.items():
        total += np.float32(weight) * smooth_noise(rng, side, cells)
    return total


def _shadows(
    rng: np.random.Generator, side: int, casters: list[tuple[Shape, bool]], sun: tuple[float, float, float]
) -> Float32[Array, "side side"]:
    """Return the share of light that reaches each texel, 1 in the open, from one ray to the sun a texel."""
    light = np.ones((side, side), np.float32)
    holes = smooth_noise(rng, side, 500)
    towards = np.array(sun, np.float32).reshape(3, 1, 1)
    for shape, solid in casters:
        centre, half = np.array(shape.centre), np.array(shape.half_extent)
        top = float(centre[2] + half[2])
        shift = -np.array(sun[:2]) * top / sun[2]
        low = np.minimum(centre[:2] - half[:2], centre[:2] - half[:2] + shift)
        high = np.maximum(centre[:2] + half[:2], centre[:2] + half[:2] + shift)
        c0, r0 = np.clip(((low + HALF_SIDE_M) / TEXEL_M).astype(int), 0, side)
        c1, r1 = np.clip(((high + HALF_SIDE_M) / TEXEL_M).astype(int) + 1, 0, side)
        x, y = np.meshgrid(np.arange(c0, c1), np.arange(r0, r1))
        points = np.stack([(x + 0.5) * TEXEL_M - HALF_SIDE_M, (y + 0.5) * TEXEL_M - HALF_SIDE_M, np.zeros(x.shape)])
        enter, leave = shape.span(points.astype(np.float32), towards)
        shaded = (enter < leave) & (leave > 0)
        patch = light[r0:r1, c0:c1]
        strength = np.float32(0.5) if solid else 0.45 + 0.5 * (holes[r0:r1, c0:c1] > 0.62)
        patch[shaded] = np.minimum(patch, strength)[shaded]
    return light
