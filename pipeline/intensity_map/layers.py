"""The layers of an intensity map (MIM, eq. 1 and 2)."""

from enum import IntEnum
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import FlatLayers, GridConfig, LayerConfig, Reduction

LAYERS = 4
_GROUND_BELOW = 0.4
"""Nothing higher than this share of the sensor's height below it is taken for ground."""


class Layer(IntEnum):
    """The place of each layer in a map; they do not overlap, the first that holds of a point is its own."""

    level = 0
    """z = 0."""
    below = 1
    """z = -epsilon."""
    upper = 2
    """(0, h]."""
    lower = 3
    """[-h, 0)."""


class IntensityLayers(NamedTuple):
    """A map of one cloud, its axes r along x and c along y."""

    total: Float32[Array, "4 n n"]
    """Sum of the intensities in each cell of each layer, in units of R."""
    count: Float32[Array, "4 n n"]
    """Number of points."""
    largest: Float32[Array, "4 n n"] | None
    """The largest intensity; None where the reduction does not ask for it."""

    def values(self, config: LayerConfig, grid: GridConfig) -> Float32[Array, "4 n n"]:
        """What eq. 1 makes of them, 0 where there is no point."""
        match config.reduction:
            case Reduction.sum:
                return self.total / np.float32(grid.cell_m * grid.cell_m)
            case Reduction.mean:
                return np.asarray(self.total / np.maximum(self.count, np.float32(1.0)))
        if self.largest is None:
            raise ValueError("these layers were made without their largest intensities")
        return self.largest


def intensity_layers(
    xyz: Float32[Array, "p 3"], intensity: Float32[Array, " p"], grid: GridConfig, config: LayerConfig
) -> IntensityLayers:
    """Sort a cloud into the cells of the layers.

    Points outside the grid, outside all layers, or not finite belong to no cell.

    Args:
        xyz: Points in the frame of the sensor, its z axis up, in metres.
        intensity: Of each point, 0 to R; what is beyond counts as R.
        grid: Where the cells lie.
        config: Where the layers lie.
    """
    x, y, z = np.ascontiguousarray(xyz.T)
    half = np.float32(grid.half_m)
    near = (np.abs(z) <= np.float32(config.height_m)) & np.isfinite(intensity)
    near &= (np.abs(x) < half) & (np.abs(y) < half)  # with NaN all of these are false
    ground = _lowest(x, y, z, grid, config) if config.ground_margin_m > 0 else None
    # one index for all arrays: numpy takes rows by number several times faster than by a mask
    chosen = np.flatnonzero(near)
    x, y, z, share = x.take(chosen), y.take(chosen), z.take(chosen), intensity.take(chosen)
    if ground is not None:
        stands_out = np.flatnonzero(z > ground.ravel().take(_block(x, y, half)) + np.float32(config.ground_margin_m))
        x, y, z, share = (column.take(stands_out) for column in (x, y, z, share))
    n, scale, middle = grid.cells, np.float32(1 / grid.cell_m), np.float32(0.5 * grid.cells)
    row = np.minimum((x * scale + middle).astype(np.int64), n - 1)
    column = np.minimum((y * scale + middle).astype(np.int64), n - 1)
    cell = (_layer_of(x, y, z, config) * n + row) * n + column
    share = np.clip(share * np.float32(1 / config.full_scale), np.float32(0), np.float32(1))
    total, count = np.zeros(LAYERS * n * n, np.float32), np.zeros(LAYERS * n * n, np.float32)
    np.add.at(total, cell, share)
    np.add.at(count, cell, np.float32(1))
    largest = None
    if config.reduction is Reduction.max:
        largest = np.zeros(LAYERS * n * n, np.float32)
        np.maximum.at(largest, cell, share)
        largest = largest.reshape(LAYERS, n, n)
    return IntensityLayers(total.reshape(LAYERS, n, n), count.reshape(LAYERS, n, n), largest)


def _layer_of(
    x: Float32[Array, " p"], y: Float32[Array, " p"], z: Float32[Array, " p"], config: LayerConfig
) -> Int64[Array, " p"]:
    """The layer of points within h above or below the sensor."""
    if config.flat is FlatLayers.angular:
        # tan is odd and rises: the edges at +t, -t and -3t are compared without an arcus tangens
        edge, lower = np.float32(np.tan(config.flat_rad)), np.float32(np.tan(3 * config.flat_rad))
        reach = np.sqrt(x * x + y * y)
        level, below = edge * reach, lower * reach
    else:
        level, below = np.float32(config.flat_m), np.float32(3 * config.flat_m)
    side = np.where(z > 0, np.int64(Layer.upper), np.int64(Layer.lower))
    flat = np.where(np.abs(z) <= level, np.int64(Layer.level), np.int64(Layer.below))
    return np.where((z <= level) & (z >= -below), flat, side)


def _block(x: Float32[Array, " k"], y: Float32[Array, " k"], half_m: np.float32) -> Int64[Array, " k"]:
    """The number of the block that points within the grid lie in."""
    blocks = _blocks(half_m)
    return (x + half_m).astype(np.int64) * blocks + (y + half_m).astype(np.int64)


def _blocks(half_m: np.float32) -> int:
    return int(np.ceil(2 * half_m))


def _lowest(
    x: Float32[Array, " p"], y: Float32[Array, " p"], z: Float32[Array, " p"], grid: GridConfig, config: LayerConfig
) -> Float32[Array, "b b"]:
    """The ground in each block of 1 m: the lowest point within it or its neighbours.

    Where no point lies low enough to be ground, it is that under the robot.
    """
    half = np.float32(grid.half_m)
    low = np.flatnonzero((z < np.float32(-_GROUND_BELOW * config.sensor_height_m)) & (np.abs(x) < half))
    x, y, z = x.take(low), y.take(low), z.take(low)
    low = np.flatnonzero(np.abs(y) < half)
    blocks = _blocks(half)
    lowest = np.full(blocks * blocks, np.inf, np.float32)
    np.minimum.at(lowest, _block(x.take(low), y.take(low), half), z.take(low))
    padded = np.pad(lowest.reshape(blocks, blocks), 1, constant_values=np.inf)
    across = np.minimum(np.minimum(padded[:-2], padded[1:-1]), padded[2:])
    around = np.minimum(np.minimum(across[:, :-2], across[:, 1:-1]), across[:, 2:])
    return np.where(np.isinf(around), np.float32(-config.sensor_height_m), around)
