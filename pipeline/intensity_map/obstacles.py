"""What a cell holds: something solid, something that yields, something transparent, or nothing (MIM, eq. 3 to 5)."""

from enum import IntEnum
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Int64, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, ObstacleConfig, Reduction
from navtool.pipeline.intensity_map.layers import IntensityLayers

TIE = 1e-4
"""Pooled intensities that exceed the threshold by less are equal to it: their sums are rounded."""


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
    """The cells with returns, by class."""

    solid: Float32[Array, "n n"]
    """I_TP of eq. 4: the largest value of any layer where one is above the threshold, else 0."""
    pliable: Float32[Array, "n n"]
    """I_FP of eq. 5: the same where none is."""
    seen: Bool[Array, "n n"]
    """Whether any point is in the cell; its intensity may be 0."""


def find_obstacles(
    layers: IntensityLayers, grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Obstacles:
    """Solid cells apart from pliable ones: condition C of eq. 3 holds where no layer is above the threshold.

    All four layers are asked: they do not overlap, so z = -epsilon is the part that [-h, 0) of eq. 3 lacks. A few
    points say little about a cell: with ``pooling_cells`` = k, the threshold is held against the reduction of the
    points of the (2k + 1) x (2k + 1) cells around. The values are the cell's own. Cells without a return are neither
    (docs/papers.md, eq. 3).

    Raises:
        ValueError: The reduction is ``max``, and the layers were made for another one.
    """
    seen = np.asarray((layers.points > 0).any(axis=0))
    # a cloud has points in few of the cells
    cells = np.flatnonzero(seen)
    there = layers.at(cells)
    highest = there.values(config, grid).max(axis=0)
    if obstacle.pooling_cells and config.reduction is Reduction.max:
        above = _largest_above(layers, cells, grid, config, obstacle)
    elif obstacle.pooling_cells:
        above = _pooled_above(there, cells, grid, config, obstacle)
    else:
        above = highest > np.float32(obstacle.threshold)  # eq. 3
    solid, pliable = np.zeros((2, *seen.shape), np.float32)
    solid.reshape(-1)[cells] = np.where(above, highest, np.float32(0))  # eq. 4
    pliable.reshape(-1)[cells] = np.where(above, np.float32(0), highest)  # eq. 5
    return Obstacles(solid, pliable, seen)


def _largest_above(
    layers: IntensityLayers, cells: Int64[Array, " k"], grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Bool[Array, " k"]:
    """In which cells the largest intensity around is above the threshold in any layer."""
    side = 2 * obstacle.pooling_cells + 1
    above = np.zeros(cells.size, bool)
    for layer in layers.values(config, grid):
        pooled = cv2.dilate(layer, np.ones((side, side), np.uint8))
        above |= pooled.ravel().take(cells) > np.float32(obstacle.threshold)
    return above


def _pooled_above(
    there: IntensityLayers, cells: Int64[Array, " k"], grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Bool[Array, " k"]:
    """In which cells the sum or the mean of the points around is above the threshold in any layer.

    Args:
        there: The layers in these cells.
        cells: All cells with returns, increasing.
        grid: Where they lie.
        config: Sum or mean.
        obstacle: Threshold and how far cells are pooled.
    """
    n, k = grid.cells, obstacle.pooling_cells
    if config.reduction is Reduction.mean:
        # the mean of some points is above the threshold where they exceed it by more than they fall short of it
        excess, elsewhere = there.total - np.float32(obstacle.threshold) * there.points, np.float32(0)
    else:
        elsewhere = np.float32(-obstacle.threshold * grid.cell_m * grid.cell_m)
        excess = there.total + elsewhere
    # nothing comes of a layer that falls short everywhere
    excess = excess[(excess > 0).any(axis=1)]
    if not len(excess):
        return np.zeros(cells.size, bool)
    # The layers lie one below the other, of the grid's rows those that matter. Beyond the edge of the grid there is
    # nothing, neither points nor area: k rows of zeros between two layers are its edge.
    first, last = max(int(cells[0]) // n - k, 0), min(int(cells[-1]) // n + k + 1, n)
    place = cells - first * n
    around = np.full((len(excess), last - first + k, n), elsewhere)
    around[:, last - first :] = 0
    around.reshape(len(excess), -1)[:, place] = excess
    ones = np.ones(2 * k + 1, np.float32)
    pooled = cv2.sepFilter2D(around.reshape(-1, n), -1, ones, ones, borderType=cv2.BORDER_CONSTANT)
    return np.asarray((pooled.reshape(len(excess), -1).take(place, axis=1) > np.float32(TIE)).any(axis=0))


def cell_classes(obstacles: Obstacles, transparent: Bool[Array, "n n"]) -> UInt8[Array, "n n"]:
    """The class of each cell; what is transparent goes before what yields, what is solid before both."""
    classes = obstacles.seen.view(np.uint8) * np.uint8(CellClass.pliable)
    classes[transparent] = CellClass.transparent
    classes[obstacles.solid > 0] = CellClass.solid
    return classes
