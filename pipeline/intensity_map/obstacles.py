"""What a cell holds: something solid, something that yields, something transparent, or nothing (MIM, eq. 3 to 5)."""

from enum import IntEnum
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, ObstacleConfig, Reduction
from navtool.pipeline.intensity_map.layers import IntensityLayers

_CRUMBS = 1e-4
"""What running sums of float32 may leave where nothing is."""


class CellClass(IntEnum):
    """What a cell holds, in ascending order of what a robot has to care about."""

    free = 0
    """No return: free space, or not seen (the paper's true negative)."""
    pliable = 1
    """Yields to the robot (false positive)."""
    solid = 2
    """Does not (true positive)."""
    transparent = 3
    """Solid, and seen by few beams or none (false negative)."""


class Obstacles(NamedTuple):
    """The cells with returns, told apart."""

    solid: Float32[Array, "n n"]
    """I_TP of eq. 4: the largest value of any layer where one is above the threshold, else 0."""
    pliable: Float32[Array, "n n"]
    """I_FP of eq. 5: the same where none is."""


def find_obstacles(
    layers: IntensityLayers, grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Obstacles:
    """Tell solid cells from pliable ones: condition C of eq. 3 holds where no layer is above the threshold.

    A few points say little about a cell: with ``pooling_cells`` = k, the threshold is held against the reduction of the
    points of the (2k + 1) x (2k + 1) cells around. The values are the cell's own. Cells without a return are neither
    (NOTES M3).
    """
    above = _above(layers, grid, config, obstacle)
    value = layers.values(config, grid)
    highest = np.maximum(np.maximum(value[0], value[1]), np.maximum(value[2], value[3]))
    solid = np.where(above, highest, np.float32(0))
    return Obstacles(solid, highest - solid)


def _above(
    layers: IntensityLayers, grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Bool[Array, "n n"]:
    """Where any layer is above the threshold."""
    side = 2 * obstacle.pooling_cells + 1
    gamma = np.float32(obstacle.threshold)
    excess = np.empty_like(layers.total)
    for layer, into in enumerate(excess):
        total, count = layers.total[layer], layers.count[layer]
        match config.reduction:
            case Reduction.mean:
                # the mean of some points is above the threshold where they exceed it by more than they fall short of it
                _box(total - gamma * count, side, into)
            case Reduction.sum:
                _box(total - gamma * np.float32(grid.cell_m * grid.cell_m), side, into)
            case Reduction.max if layers.largest is not None:
                np.subtract(cv2.dilate(layers.largest[layer], np.ones((side, side), np.uint8)), gamma, out=into)
            case _:
                raise ValueError("these layers were made without their largest intensities")
    highest = np.maximum(np.maximum(excess[0], excess[1]), np.maximum(excess[2], excess[3]))
    return np.asarray(highest > np.float32(_CRUMBS))


def _box(values: Float32[Array, "n n"], side: int, into: Float32[Array, "n n"]) -> None:
    """Sums over squares of cells; what lies outside the grid is 0."""
    if side == 1:
        into[:] = values
    else:
        cv2.boxFilter(values, -1, (side, side), into, normalize=False, borderType=cv2.BORDER_CONSTANT)


def cell_classes(obstacles: Obstacles, transparent: Bool[Array, "n n"]) -> Array:
    """The class of each cell as uint8; what is transparent goes before what yields, what is solid before both."""
    classes = np.where(obstacles.pliable > 0, np.uint8(CellClass.pliable), np.uint8(CellClass.free))
    classes[transparent] = CellClass.transparent
    classes[obstacles.solid > 0] = CellClass.solid
    return classes
