"""Which point of a cloud belongs to which layer and cell of an intensity map (MIM, eq. 1 and 2)."""

from enum import IntEnum
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import FlatLayers, GridConfig, LayerConfig

GROUND_BELOW = 0.1
"""Nothing higher than this share of the sensor's height below it is taken for ground: hills rise, and robots nod."""


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


_NEIGHBOURS = np.ones((3, 3), np.uint8)
_FROM_ABOVE = np.array([Layer.upper, Layer.level, Layer.below, Layer.lower], np.int64)


class LayerPoints(NamedTuple):
    """The points of a cloud that lie in a layer and within the grid, in the cloud's order."""

    x: Float32[Array, " k"]
    y: Float32[Array, " k"]
    share: Float32[Array, " k"]
    """Intensity in units of R, 0 to 1."""
    cell: Int64[Array, " k"]
    """Where in a map of layers, rows and columns: (layer n + r) n + c."""


def sort_points(
    xyz: Float32[Array, "p 3"], intensity: Float32[Array, " p"], grid: GridConfig, config: LayerConfig
) -> LayerPoints:
    """Find the layer and the cell of each point.

    Points outside the grid, outside all layers, on the ground, or with anything that is not finite are left out; a
    cloud may be empty.

    Args:
        xyz: Points in the frame of the sensor, its z axis up, in metres.
        intensity: Of each point, 0 to R; what is beyond counts as 0 or R.
        grid: Where the cells lie.
        config: Where the layers lie.
    """
    half = np.float32(grid.half_m)
    height = np.ascontiguousarray(xyz[:, 2])
    # numbers of rows, not masks: numpy takes rows by number several times faster; with NaN all comparisons are false
    near = np.flatnonzero(np.abs(height) <= np.float32(config.height_m))
    x, y, z = np.ascontiguousarray(xyz.take(near, axis=0).T)
    share = intensity.take(near)
    chosen = (np.abs(x) <= half) & (np.abs(y) <= half) & (x != half) & (y != half) & np.isfinite(share)
    x, y, z, share = _taken(chosen, x, y, z, share)
    if config.ground_margin_m > 0:
        ground = _ground(xyz, height, grid, config).ravel().take(_block(x, y, half))
        x, y, z, share = _taken(z > ground + np.float32(config.ground_margin_m), x, y, z, share)
    row, column = cell_numbers(x, grid), cell_numbers(y, grid)
    cell = (_layer_of(x, y, z, config) * grid.cells + row) * grid.cells + column
    share = np.clip(share * np.float32(1 / config.full_scale), np.float32(0), np.float32(1))
    return LayerPoints(x, y, share, cell)


def cell_numbers(coordinate_m: Float32[Array, " k"], grid: GridConfig) -> Int64[Array, " k"]:
    """The row of each x, or the column of each y; what lies beyond the grid gets the nearest one."""
    number = (coordinate_m * np.float32(1 / grid.cell_m) + np.float32(0.5 * grid.cells)).astype(np.int64)
    return np.asarray(np.minimum(np.maximum(number, 0), grid.cells - 1))


def _taken(mask: Bool[Array, " p"], *columns: Float32[Array, " p"]) -> tuple[Float32[Array, " k"], ...]:
    """What the mask chooses of each column; the columns themselves where it chooses all."""
    index = np.flatnonzero(mask)
    return columns if index.size == mask.size else tuple(column.take(index) for column in columns)


def _layer_of(
    x: Float32[Array, " k"], y: Float32[Array, " k"], z: Float32[Array, " k"], config: LayerConfig
) -> Int64[Array, " k"]:
    """The layer of points within h above or below the sensor."""
    if config.flat is FlatLayers.angular:
        # tan is odd and rises: the edges at +t, -t and -3t are compared without an arcus tangens
        edge, lower = np.float32(np.tan(config.flat_rad)), np.float32(np.tan(3 * config.flat_rad))
        reach = np.sqrt(x * x + y * y)
        level, below = edge * reach, lower * reach
    else:
        level, below = np.full_like(z, config.flat_m), np.full_like(z, 3 * config.flat_m)
    edges_above = (z <= level).view(np.uint8) + (z < -level).view(np.uint8) + (z < -below).view(np.uint8)
    return np.asarray(_FROM_ABOVE.take(edges_above))


def ground_blocks(grid: GridConfig) -> int:
    """How many blocks of 1 m the grid has along an axis."""
    return int(np.ceil(2 * grid.half_m))


def _block(x: Float32[Array, " k"], y: Float32[Array, " k"], half_m: np.float32) -> Int64[Array, " k"]:
    """The number of the block that points within the grid lie in."""
    blocks = int(np.ceil(2 * half_m))
    # the sum may be rounded up to the far edge itself
    row = np.minimum((x + half_m).astype(np.int64), blocks - 1)
    return np.asarray(row * blocks + np.minimum((y + half_m).astype(np.int64), blocks - 1))


def _ground(
    xyz: Float32[Array, "p 3"], height: Float32[Array, " p"], grid: GridConfig, config: LayerConfig
) -> Float32[Array, "b b"]:
    """The ground in each block of 1 m: what is left of its lowest points when all that is narrower than 3 m is cut off.

    Of the lowest points around (an erosion) the highest around (a dilation) is the ground: slopes stay as they are,
    while blocks without a point on the ground get that of their neighbours. Blocks without any low point do not raise
    it: behind a wall there is nothing lower than the wall. Where no point lies low enough to be ground, it is that
    under the robot.
    """
    half = np.float32(grid.half_m)
    low = (height < np.float32(-GROUND_BELOW * config.sensor_height_m)) & (height > -np.inf)
    x, y, z = np.ascontiguousarray(xyz.take(np.flatnonzero(low), axis=0).T)
    x, y, z = _taken((np.abs(x) < half) & (np.abs(y) < half), x, y, z)
    blocks = ground_blocks(grid)
    lowest = np.full(blocks * blocks, np.inf, np.float32)
    np.minimum.at(lowest, _block(x, y, half), z)
    low_points = lowest.reshape(blocks, blocks)
    # with blocks repeated beyond the edge, since OpenCV's own border is a finite number
    around = cv2.erode(low_points, _NEIGHBOURS, borderType=cv2.BORDER_REPLICATE)
    known = np.where(low_points == np.inf, np.float32(-np.inf), around)
    opened = cv2.dilate(known, _NEIGHBOURS, borderType=cv2.BORDER_REPLICATE)
    return np.where(around == np.inf, np.float32(-config.sensor_height_m), np.maximum(opened, around))
