"""How solid each cell looks: the threshold of eq. 3 that it would just pass (MIM, section IV-A)."""

import cv2
import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, ObstacleConfig, Reduction
from navtool.pipeline.intensity_map.layers import IntensityLayers


def solidity(
    layers: IntensityLayers, grid: GridConfig, config: LayerConfig, obstacle: ObstacleConfig
) -> Float32[Array, "n n"]:
    """What `find_obstacles` holds against the threshold Gamma: a cell is solid with every Gamma below its solidity.

    It is the largest of the layers' reductions over the (2k + 1) x (2k + 1) cells around, k being ``pooling_cells``, in
    the threshold's own unit. Cells without a return have 0.

    Raises:
        ValueError: The reduction is ``max``, and the layers were made for another one.
    """
    seen = layers.points.sum(axis=0) > 0
    side = 2 * obstacle.pooling_cells + 1
    if config.reduction is Reduction.max:
        around = np.ones((side, side), np.uint8)
        pooled = np.stack([cv2.dilate(layer, around) for layer in layers.values(config, grid)])
    else:
        number = layers.points
        if config.reduction is Reduction.sum:
            number = np.full_like(layers.points, grid.cell_m * grid.cell_m)
        total, number = (_sums(part, side) for part in (layers.total, number))
        pooled = np.divide(total, number, out=np.zeros_like(total), where=number > 0)
    return np.where(seen, pooled.max(axis=0), np.float32(0))


def _sums(layers: Float32[Array, "4 n n"], side: int) -> Float32[Array, "4 n n"]:
    """Over the squares around each cell; beyond the edge of the grid there is nothing."""
    ones = np.ones(side, np.float32)
    summed = [cv2.sepFilter2D(layer, -1, ones, ones, borderType=cv2.BORDER_CONSTANT) for layer in layers]
    return np.asarray(np.stack(summed), np.float32)
