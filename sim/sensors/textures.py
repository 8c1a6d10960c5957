"""Procedural textures: what a square of each surface looks like from near by, without seams."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Float, Float32, Int32

from navtool.pipeline.arrays import Array
from navtool.sim.world.surfaces import SURFACES

TILE_M = 1.6
"""Side of the square, after which it repeats."""
TILE_PX = 512
LEVELS = 8
"""How often it is halved for surfaces farther away."""
_BANK_SEED = 20
_SEAM_PX = 8
"""Strokes are no wider than this, edges included."""


class TextureBank(NamedTuple):
    """The textures of all surfaces in one row of numbers, for look-up by many pixels at once."""

    values: Float32[Array, " texels"]
    """Brightness relative to the surface's colour; its mean is 1."""
    start: Int32[Array, " levels"]
    """Where each level begins: level by level, surface by surface, row by row."""

    def look_up(
        self,
        surface: Int32[Array, " n"],
        across_m: Float32[Array, " n"],
        up_m: Float32[Array, " n"],
        footprint_m: Float32[Array, " n"],
    ) -> Float32[Array, " n"]:
        """The brightness at points of surfaces.

        Args:
            surface: Numbers of the surfaces.
            across_m: Position on the surface along its first axis.
            up_m: Position along its second axis.
            footprint_m: Width of what a pixel sees there: finer detail is averaged.
        """
        texels = np.maximum(footprint_m * np.float32(TILE_PX / TILE_M), np.float32(1))
        level = np.minimum(np.log2(texels).astype(np.int32), LEVELS - 1)
        size = np.int32(TILE_PX) >> level
        scale = size.astype(np.float32) * np.float32(1 / TILE_M)
        column = np.floor(across_m * scale).astype(np.int32) & (size - 1)
        row = np.floor(up_m * scale).astype(np.int32) & (size - 1)
        return np.asarray(self.values[self.start[level] + (surface * size + row) * size + column])


@lru_cache(maxsize=1)
def texture_bank() -> TextureBank:
    """The textures of all surfaces; always the same."""
    tiles = np.stack([_tile(number) for number in range(len(SURFACES))])
    levels, starts, start = [], [], 0
    for _ in range(LEVELS):
        starts.append(start)
        levels.append(tiles.ravel())
        start += tiles.size
        tiles = 0.25 * (tiles[:, ::2, ::2] + tiles[:, 1::2, ::2] + tiles[:, ::2, 1::2] + tiles[:, 1::2, 1::2])
    return TextureBank(np.concatenate(levels).astype(np.float32), np.array(starts, np.int32))


def _tile(number: int) -> Float[Array, "h w"]:
    """The texture of one surface with its mean and contrast."""
    surface = SURFACES[number]
    raw = _PATTERNS.get(surface.name, _speckle)(np.random.default_rng([_BANK_SEED, number]))
    spread = float(raw.std())
    tile = 1 + surface.contrast * (raw - raw.mean()) / max(spread, 1e-6)
    tile = np.clip(tile, 0.08, 2.6)
    return np.asarray(tile / tile.mean(), np.float32)


def _noise(rng: np.random.Generator, rows: float, columns: float) -> Float[Array, "h w"]:
    """Noise without seams whose features are so many texels high and wide."""
    frequency_y, frequency_x = np.fft.fftfreq(TILE_PX)[:, None], np.fft.rfftfreq(TILE_PX)[None, :]
    kept = np.exp(-((frequency_y * rows) ** 2) - (frequency_x * columns) ** 2)
    spectrum = np.fft.rfft2(rng.standard_normal((TILE_PX, TILE_PX))) * kept
    noise = np.fft.irfft2(spectrum, s=(TILE_PX, TILE_PX))
    return np.asarray((noise - noise.mean()) / noise.std(), np.float32)


def _speckle(rng: np.random.Generator) -> Float[Array, "h w"]:
    return np.asarray(_noise(rng, 2.0, 2.0) + 0.7 * _noise(rng, 8.0, 8.0) + 0.7 * _noise(rng, 60.0, 60.0))


def _concrete(rng: np.random.Generator) -> Float[Array, "h w"]:
    """Stains, pores, and a crack or two."""
    stained = 0.8 * _noise(rng, 1.5, 1.5) + 0.5 * _noise(rng, 25.0, 25.0) + 0.4 * _noise(rng, 140.0, 140.0)
    pores = _noise(rng, 3.0, 3.0) > 2.6
    crack = np.abs(_noise(rng, 90.0, 90.0) + 0.12 * _noise(rng, 12.0, 12.0)) < 0.012
    return np.asarray(stained - 2.5 * pores - 3.0 * crack)


def _asphalt(rng: np.random.Generator) -> Float[Array, "h w"]:
    grains = _noise(rng, 2.5, 2.5)
    return np.asarray(grains + 1.5 * (grains > 1.6) + 0.5 * _noise(rng, 80.0, 80.0))


def _sand(rng: np.random.Generator) -> Float[Array, "h w"]:
    """Ripples and grains."""
    y = np.arange(TILE_PX)[:, None] / TILE_PX
    bent = y * 14 + 0.35 * _noise(rng, 60.0, 90.0)
    ripples = np.sin(2 * np.pi * bent)
    return np.asarray(0.8 * ripples + 0.6 * _noise(rng, 1.5, 1.5) + 0.8 * _noise(rng, 90.0, 90.0))


def _stones(rng: np.random.Generator, count: int) -> Float[Array, "h w"]:
    """Rounded stones, each of its own shade, with dark gaps."""
    side = np.sqrt(count)
    places = rng.uniform(0, TILE_PX, (count, 2)).astype(np.float32)
    shade = rng.normal(0.0, 0.8, count).astype(np.float32)
    ghosts = np.concatenate([places + np.float32(TILE_PX) * np.array([i, j]) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    near = np.full((TILE_PX, TILE_PX), np.inf, np.float32)
    second, owner = near.copy(), np.zeros((TILE_PX, TILE_PX), np.int32)
    reach = int(2.6 * TILE_PX / side)
    for index, (row, column) in enumerate(ghosts.tolist()):
        top, left = max(int(row) - reach, 0), max(int(column) - reach, 0)
        bottom, right = min(int(row) + reach, TILE_PX), min(int(column) + reach, TILE_PX)
        if top >= bottom or left >= right:
            continue
        window = slice(top, bottom), slice(left, right)
        rows, columns = np.ogrid[window]
        distance = np.hypot(rows - row, columns - column).astype(np.float32)
        closer = distance < near[window]
        second[window] = np.where(closer, near[window], np.minimum(second[window], distance))
        owner[window] = np.where(closer, index % count, owner[window])
        near[window] = np.minimum(near[window], distance)
    gap = np.clip((second - near) / (0.5 * TILE_PX / side), 0, 1)
    dome = np.sqrt(gap)
    return np.asarray(shade[owner] + 2.2 * dome + 0.25 * _noise(rng, 2.0, 2.0), np.float32)


def _strokes(
    rng: np.random.Generator, count: int, length_px: float, width_px: int, spread_rad: float
) -> Float[Array, "h w"]:
    """Blades or chips that lie over each other, later ones brighter: those below are in the shade."""
    canvas = np.full((3 * TILE_PX, 3 * TILE_PX), -1.5, np.float32)
    places = rng.uniform(0, TILE_PX, (count, 2))
    angles = rng.uniform(0, 2 * np.pi, count) if spread_rad >= np.pi else rng.normal(0.0, spread_rad, count)
    lengths = length_px * rng.uniform(0.5, 1.3, count)
    shades = np.linspace(-1.3, 0.9, count) + rng.normal(0.0, 0.55, count)
    ends = places + lengths[:, None] * np.stack([np.sin(angles), -np.cos(angles)], axis=1)
    shifts = np.array([(i, j) for i in (0, 1, 2) for j in (0, 1, 2)]) * TILE_PX
    first, last = (np.stack([places, ends])[:, :, None] + shifts).round().astype(int)
    # of the nine copies only those that reach into the middle can be seen
    seen = (np.maximum(first, last) > TILE_PX - _SEAM_PX) & (np.minimum(first, last) < 2 * TILE_PX + _SEAM_PX)
    stroke, copy = np.nonzero(seen.all(axis=2))
    lines = np.concatenate([first[stroke, copy], last[stroke, copy]], axis=1).tolist()
    for (x0, y0, x1, y1), shade in zip(lines, shades[stroke].tolist(), strict=True):
        cv2.line(canvas, (x0, y0), (x1, y1), shade, width_px, cv2.LINE_AA)
    middle = canvas[TILE_PX : 2 * TILE_PX, TILE_PX : 2 * TILE_PX]
    return np.asarray(cv2.GaussianBlur(middle, (3, 3), 0.7) + 0.35 * _noise(rng, 70.0, 70.0), np.float32)


def _bark(rng: np.random.Generator) -> Float[Array, "h w"]:
    ridges = np.abs(_noise(rng, 90.0, 10.0) + 0.3 * _noise(rng, 10.0, 5.0))
    return np.asarray(1.6 * np.minimum(ridges, 1.0) + 0.4 * _noise(rng, 3.0, 2.0) + 0.4 * _noise(rng, 120.0, 60.0))


def _brick(rng: np.random.Generator) -> Float[Array, "h w"]:
    """Courses of bricks of their own shades in pale mortar: 20 cm by 6.7 cm."""
    courses, bricks = 24, 8
    row = np.arange(TILE_PX) * courses / TILE_PX
    course = row.astype(int)
    column = np.arange(TILE_PX)[None, :] * bricks / TILE_PX + 0.5 * (course[:, None] % 2)
    shade = rng.normal(0.0, 1.0, (courses, bricks))[course[:, None], column.astype(int) % bricks]
    joint = ((row % 1) < 0.16)[:, None] | ((column % 1) < 0.05)
    return np.asarray(np.where(joint, 2.4, 0.7 * shade) + 0.4 * _noise(rng, 2.0, 2.0), np.float32)


def _mud(rng: np.random.Generator) -> Float[Array, "h w"]:
    """Smooth, with wet spots that mirror the sky."""
    wet = _noise(rng, 50.0, 50.0) + 0.4 * _noise(rng, 12.0, 12.0)
    return np.asarray(0.5 * _noise(rng, 5.0, 5.0) + 0.6 * _noise(rng, 25.0, 25.0) + 2.0 * (wet > 1.3))


_PATTERNS: dict[str, Callable[[np.random.Generator], Float[Array, "h w"]]] = {
    "concrete": _concrete,
    "asphalt": _asphalt,
    "sand": _sand,
    "gravel": lambda rng: _stones(rng, 2600),
    "rock_bed": lambda rng: _stones(rng, 130),
    "mulch": lambda rng: _strokes(rng, 5000, 16.0, 3, np.pi),
    "grass": lambda rng: _strokes(rng, 16000, 18.0, 1, np.pi),
    "mud": _mud,
    "bark": _bark,
    "brick": _brick,
}
