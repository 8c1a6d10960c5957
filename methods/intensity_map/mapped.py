"""A sweep with its map: what all writers take."""

from functools import cached_property
from typing import Final

from jaxtyping import Float32, UInt8

from navtool.methods.along.sweeps import Sweep
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.mapper import IntensityMap

LAYER_NAMES: Final = ("level", "below", "upper", "lower")
"""Names of the layers of a map, in its order: z = 0, z = -epsilon, (0, h] and [-h, 0)."""


class MappedSweep:
    """One map of a run.

    Attributes:
        number: Of the map, from 0 on.
        sweep: What it was made of.
        map: What it shows; r along x, c along y.
        goal_rad: Direction of the goal in the frame of the map.
        config: By which it was made.
    """

    def __init__(
        self, number: int, sweep: Sweep, made: IntensityMap, goal_rad: float, config: IntensityMapConfig
    ) -> None:
        self.number, self.sweep, self.map = number, sweep, made
        self.goal_rad, self.config = goal_rad, config

    @cached_property
    def values(self) -> Float32[Array, "4 n n"]:
        """What eq. 1 makes of the layers, in units of R; 0 where there is no point."""
        return self.map.layers.values(self.config.layers, self.config.grid)

    @property
    def classes(self) -> UInt8[Array, "n n"]:
        """A `CellClass` for each cell."""
        return self.map.classes
