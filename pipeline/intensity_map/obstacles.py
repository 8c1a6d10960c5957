"""What a cell holds: something solid, something that yields, something transparent, or nothing (MIM, eq. 3 to 5)."""

from enum import IntEnum
from typing import NamedTuple

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, ObstacleConfig, Reduction
from navtool.pipeline.intensity_map.layer_points import Layer
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
    """The cells with returns, told apart."""

    solid: Float32[Array, "n n"]
    """I_TP of eq. 4: the largest value of any layer where one is above the threshold, else 0."""
    pliable: Float32[Array, "n n"]
    """I_FP of eq. 5: the same where none is."""
    seen: Bool[Array, "n n"]
    """Whether any point is in the cell; its intensity may be 0."""


def find_obstacles(
    layers: IntensityLayers, grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Obstacles:
    """Tell solid cells from pliable ones: condition C of eq. 3 holds where no layer is above the threshold.

    All four layers are asked: they do not overlap, so z = -epsilon is the part that [-h, 0) of eq. 3 lacks. A few
    points say little about a cell: with ``pooling_cells`` = k, the threshold is held against the reduction of the
    points of the (2k + 1) x (2k + 1) cells around. The values are the cell's own. Cells without a return are neither
    (NOTES M3).

    Raises:
        ValueError: The reduction is ``max``, and the layers were made for another one.
    """
    highest = layers.value(Layer.level, config, grid)
    for layer in (Layer.below, Layer.upper, Layer.lower):
        highest = np.maximum(highest, layers.value(layer, config, grid))
    if obstacle.pooling_cells:
        above = _above(layers, grid, config, obstacle)
    else:
        above = highest > np.float32(obstacle.threshold)  # eq. 3
    solid = np.where(above, highest, np.float32(0))  # eq. 4
    level, below, upper, lower = layers.points
    return Obstacles(solid, highest - solid, level + below + upper + lower > 0)  # eq. 5


def _above(
    layers: IntensityLayers, grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Bool[Array, "n n"]:
    """Where the reduction of the points around is above the threshold in any layer."""
    side = 2 * obstacle.pooling_cells + 1
    ones = np.ones(side, np.float32)
    above = np.zeros(layers.total.shape[1:], bool)
    for layer in Layer:
        if config.reduction is Reduction.max:
            pooled = cv2.dilate(layers.known_largest()[layer], np.ones((side, side), np.uint8))
            above |= pooled > np.float32(obstacle.threshold)
            continue
        # the mean of some points is above the threshold where they exceed it by more than they fall short of it
        if config.reduction is Reduction.mean:
            excess = cv2.scaleAdd(layers.points[layer], -obstacle.threshold, layers.total[layer])
        else:
            excess = layers.total[layer] - np.float32(obstacle.threshold * grid.cell_m * grid.cell_m)
        # beyond the edge of the grid there is nothing, neither points nor area
        above |= cv2.sepFilter2D(excess, -1, ones, ones, borderType=cv2.BORDER_CONSTANT) > np.float32(TIE)
    return above


def cell_classes(obstacles: Obstacles, transparent: Bool[Array, "n n"]) -> UInt8[Array, "n n"]:
    """The class of each cell; what is transparent goes before what yields, what is solid before both."""
    classes = obstacles.seen.view(np.uint8) * np.uint8(CellClass.pliable)
    classes[transparent] = CellClass.transparent
    classes[obstacles.solid > 0] = CellClass.solid
    return classes
