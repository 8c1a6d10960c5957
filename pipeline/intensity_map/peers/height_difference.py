"""A map of height differences: solid is where points of one cell lie far above each other."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, UInt8

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.layer_points import cell_numbers
from navtool.pipeline.intensity_map.obstacles import CellClass


@dataclass(kw_only=True, slots=True)
class HeightDifferenceConfig:
    """Which heights count."""

    step_m: float = 0.25
    """A cell is solid where its highest point lies further above its lowest; above 0."""
    ceiling_m: float = 0.5
    """What is higher above the sensor does not count: the robot passes below; above 0."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, math.inf, "step_m", "ceiling_m", unit="m", above=True))


def height_difference_map(
    xyz: Float32[Array, "p 3"], grid: GridConfig, config: HeightDifferenceConfig
) -> UInt8[Array, "n n"]:
    """The class of each cell: solid where its heights differ by more than a step, else free.

    Args:
        xyz: Points in the frame of the sensor, its z axis up, in metres.
        grid: Where the cells lie.
        config: Which heights.
    """
    x, y, z = np.ascontiguousarray(xyz.T)
    half = grid.half_m
    chosen = (x >= -half) & (x < half) & (y >= -half) & (y < half) & (z <= config.ceiling_m) & (z > -np.inf)
    index = np.flatnonzero(chosen)
    cell = cell_numbers(x[index], grid) * grid.cells + cell_numbers(y[index], grid)
    low = np.full(grid.cells * grid.cells, np.inf, np.float32)
    high = np.full(grid.cells * grid.cells, -np.inf, np.float32)
    np.minimum.at(low, cell, z[index])
    np.maximum.at(high, cell, z[index])
    solid = (high - low > np.float32(config.step_m)).reshape(grid.cells, grid.cells)
    return np.where(solid, np.uint8(CellClass.solid), np.uint8(CellClass.free))
