"""Which point of a cloud belongs to which layer and cell of an intensity map (MIM, eq. 1 and 2)."""

from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int32, Int64, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import FlatLayers, GridConfig, LayerConfig

STEEPEST_GROUND = 0.12
"""Nothing that rises above the ground of the robot by more than this share of its distance is ground: hills rise by
a tenth and robots nod, so that ground 10 m away may be higher than the sensor, and ground 3 m away may not."""


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
    place = np.ascontiguousarray(xyz.T)
    x, y, z = place
    half = np.float32(grid.half_m)
    # with NaN all comparisons are false
    inside = (x >= -half) & (x < half) & (y >= -half) & (y < half) & np.isfinite(z)
    if not inside.all():
        place, intensity = _taken(place, intensity, inside)
    height = place[2]
    chosen = (np.abs(height) <= np.float32(config.height_m)) & np.isfinite(intensity)
    if config.ground_margin_m > 0:
        block = _block(place, grid)
        lowest = _ground(height, block, grid, config) + np.float32(config.ground_margin_m)
        chosen &= height > lowest.take(block)
    standing, share = _taken(place, intensity, chosen)
    share = np.clip(share * np.float32(1 / config.full_scale), np.float32(0), np.float32(1))
    return LayerPoints(standing[0], standing[1], share, _layer_cells(standing, grid, config))


def _taken(
    place: Float32[Array, "3 p"], intensity: Float32[Array, " p"], chosen: Bool[Array, " p"]
) -> tuple[Float32[Array, "3 k"], Float32[Array, " k"]]:
    # numbers of points, not masks: numpy takes by number several times faster
    index = np.flatnonzero(chosen)
    return place.take(index, axis=1), intensity.take(index)


def cell_numbers(coordinate_m: Float32[Array, "*k"], grid: GridConfig) -> Int64[Array, "*k"]:
    """The row of each x, or the column of each y; what lies beyond the grid gets the nearest one."""
    number = coordinate_m * np.float32(1 / grid.cell_m) + np.float32(0.5 * grid.cells)
    return np.asarray(np.minimum(np.maximum(number, np.float32(0)), np.float32(grid.cells - 1)).astype(np.int64))


def _layer_cells(place: Float32[Array, "3 k"], grid: GridConfig, config: LayerConfig) -> Int64[Array, " k"]:
    """The number of the cell in a map of layers, of points within the grid."""
    number = place[:2] * np.float32(1 / grid.cell_m)
    number += np.float32(0.5 * grid.cells)
    row, column = _whole(number, grid.cells)
    layer = _layer_of(place, config).astype(np.int32)
    n = np.int32(grid.cells)
    return np.asarray(((layer * n + row) * n + column).astype(np.int64))


def _whole(number: Float32[Array, "2 k"], limit: int) -> Int32[Array, "2 k"]:
    """Whole rows and columns below a limit, of numbers that are at least 0.

    NumPy turns floats into int32 four times as fast as into int64.
    """
    whole = number.astype(np.int32)
    # sums may have been rounded up to the far edge itself; a look costs a fifth of a change
    return np.minimum(whole, np.int32(limit - 1)) if whole.max(initial=0) >= limit else whole


def _layer_of(place: Float32[Array, "3 k"], config: LayerConfig) -> UInt8[Array, " k"]:
    """The `Layer` of points within h above or below the sensor."""
    x, y, z = place
    level, below = np.float32(config.flat_m), np.float32(3 * config.flat_m)
    if config.flat is FlatLayers.angular:
        # tan is odd and rises: the edges at +t, -t and -3t are compared without an arcus tangens
        reach = np.sqrt(x * x + y * y)
        level = np.float32(np.tan(config.flat_rad)) * reach
        below = np.float32(np.tan(3 * config.flat_rad)) * reach
    depth = -z
    beneath = depth > level
    steep = (z > level) | (depth > below)
    # level, below, upper and lower count as 00, 01, 10 and 11
    return np.asarray(steep.view(np.uint8) * np.uint8(2) + beneath.view(np.uint8))


def ground_blocks(grid: GridConfig) -> int:
    """How many blocks of 1 m the grid has along an axis."""
    return int(np.ceil(2 * grid.half_m))


def ground_limits(grid: GridConfig, config: LayerConfig) -> Float32[Array, "b b"]:
    """What may be ground in each block lies lower, in metres above the sensor."""
    return _limits(ground_blocks(grid), grid.half_m, config.sensor_height_m).copy()


@lru_cache(maxsize=8)
def _limits(blocks: int, half_m: float, sensor_height_m: float) -> Float32[Array, "b b"]:
    middle = np.abs(np.arange(blocks, dtype=np.float32) + np.float32(0.5 - half_m))
    away = np.hypot(middle[:, None], middle[None, :])
    return np.asarray(np.float32(STEEPEST_GROUND) * away - np.float32(sensor_height_m), np.float32)


def _block(place: Float32[Array, "3 k"], grid: GridConfig) -> Int64[Array, " k"]:
    """The number of the block that points within the grid lie in."""
    blocks = ground_blocks(grid)
    row, column = _whole(place[:2] + np.float32(grid.half_m), blocks)
    return np.asarray((row * np.int32(blocks) + column).astype(np.int64))


def _ground(
    height: Float32[Array, " p"], block: Int64[Array, " p"], grid: GridConfig, config: LayerConfig
) -> Float32[Array, " b"]:
    """The ground in each block of 1 m: what is left of its lowest points when all that is narrower than 3 m is cut off.

    Of the lowest points around that are not too high for their distance (an erosion) the highest around (a dilation) is
    the ground: slopes stay as they are, while blocks without a point on the ground get that of their neighbours. Blocks
    without any such point do not raise it: behind a wall there is nothing lower than the wall. Where no point around
    may be ground, it is that under the robot.

    Args:
        height: z of points within the grid, finite.
        block: The block of each.
        grid: Where the blocks lie.
        config: How high the sensor is.
    """
    blocks = ground_blocks(grid)
    lowest = np.full(blocks * blocks, np.inf, np.float32)
    np.minimum.at(lowest, block, height)
    low_points = lowest.reshape(blocks, blocks)
    low_points[low_points >= ground_limits(grid, config)] = np.inf
    # with blocks repeated beyond the edge, since OpenCV's own border is a finite number
    around = cv2.erode(low_points, _NEIGHBOURS, borderType=cv2.BORDER_REPLICATE)
    known = np.where(low_points == np.inf, np.float32(-np.inf), around)
    opened = cv2.dilate(known, _NEIGHBOURS, borderType=cv2.BORDER_REPLICATE)
    return np.where(around == np.inf, np.float32(-config.sensor_height_m), opened).ravel()
