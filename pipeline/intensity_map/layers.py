"""The layers of an intensity map (MIM, eq. 1 and 2)."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, Reduction
from navtool.pipeline.intensity_map.layer_points import Layer, LayerPoints


class IntensityLayers(NamedTuple):
    """A map of one cloud, its axes r along x and c along y, or some of its cells; the layers are those of `Layer`."""

    total: Float32[Array, " 4 *cells"]
    """Sum of the intensities in each cell of each layer, in units of R."""
    points: Float32[Array, " 4 *cells"]
    """Number of points."""
    largest: Float32[Array, " 4 *cells"] | None
    """The largest intensity; None where the reduction does not ask for it."""

    def at(self, cells: Int64[Array, " k"]) -> "IntensityLayers":
        """Some cells alone, numbered r n + c."""
        shape = (len(Layer), -1)
        largest = None if self.largest is None else self.largest.reshape(shape).take(cells, axis=1)
        total, points = self.total.reshape(shape), self.points.reshape(shape)
        return IntensityLayers(total.take(cells, axis=1), points.take(cells, axis=1), largest)

    def values(self, config: LayerConfig, grid: GridConfig) -> Float32[Array, " 4 *cells"]:
        """What eq. 1 makes of them, 0 where there is no point.

        Raises:
            ValueError: The reduction is ``max``, and the layers were made for another one.
        """
        match config.reduction:
            case Reduction.sum:
                return np.asarray(self.total / np.float32(grid.cell_m * grid.cell_m))  # eq. 1
            case Reduction.mean:
                return np.asarray(self.total / np.maximum(self.points, np.float32(1)))
            case Reduction.max:
                if self.largest is None:
                    raise ValueError("these layers were made without their largest intensities; make them for max")
                return self.largest


def intensity_layers(points: LayerPoints, grid: GridConfig, config: LayerConfig) -> IntensityLayers:
    """Gather the points of a cloud in the cells of the layers.

    Args:
        points: Of `sort_points`, for the same grid.
        grid: Where the cells lie.
        config: What a cell holds.
    """
    shape = (len(Layer), grid.cells, grid.cells)
    # One array of both: glibc gives memory back to the system beyond twice the largest array that it has freed. With
    # two arrays of half the size a map lies beyond that, and takes its pages anew each time: 580 faults, 0.9 ms.
    total, number = np.zeros((2, *shape), np.float32)
    np.add.at(total.reshape(-1), points.cell, points.share)
    np.add.at(number.reshape(-1), points.cell, np.float32(1))
    if config.reduction is not Reduction.max:
        return IntensityLayers(total, number, None)
    largest = np.zeros(shape, np.float32)
    np.maximum.at(largest.reshape(-1), points.cell, points.share)
    return IntensityLayers(total, number, largest)
