"""The map of a planar scanner: the nearest returns of one ring are solid."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32, Int64, UInt8

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.layer_points import cell_numbers
from navtool.pipeline.intensity_map.obstacles import CellClass


@dataclass(kw_only=True, slots=True)
class LaserScanConfig:
    """Which ring of a cloud is the planar scan."""

    elevation_rad: float = math.radians(1.0)
    """Elevation of the ring, in (-0.5, 0.5); a VLP-16 has one at 1 degree."""
    opening_rad: float = math.radians(1.5)
    """Points whose elevation is off by less than half of this belong to the ring; in (0, 0.2]."""
    beams: int = 720
    """Beams of a turn, at least 8: the nearest return of each counts."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, -0.5, 0.5, "elevation_rad", unit="rad", above=True, below=True),
            outside(self, 0, 0.2, "opening_rad", unit="rad", above=True),
            outside(self, 8, math.inf, "beams", cure="a turn has at least 8"),
        )


def one_ring(xyz: Float32[Array, "p 3"], config: LaserScanConfig) -> Int64[Array, " k"]:
    """The points of the ring, by azimuth; where several lie in a beam, the nearest."""
    with np.errstate(invalid="ignore", over="ignore"):
        reach = np.hypot(xyz[:, 0], xyz[:, 1])
        off = np.abs(np.arctan2(xyz[:, 2], reach) - np.float32(config.elevation_rad))
    index = np.flatnonzero((off < config.opening_rad / 2) & np.isfinite(reach) & (reach > 0))
    turn = np.arctan2(xyz[index, 1], xyz[index, 0]).astype(np.float64) / (2 * np.pi) + 0.5
    beam = np.minimum((turn * config.beams).astype(np.int64), config.beams - 1)
    order = np.lexsort((reach[index], beam))
    first = np.ones(order.size, bool)
    first[1:] = beam[order][1:] != beam[order][:-1]
    return np.asarray(index[order[first]])


def laser_scan_map(xyz: Float32[Array, "p 3"], grid: GridConfig, config: LaserScanConfig) -> UInt8[Array, "n n"]:
    """The class of each cell: solid where a beam of the ring returns, else free.

    Args:
        xyz: Points in the frame of the sensor, in metres.
        grid: Where the cells lie.
        config: Which ring.
    """
    return mark(xyz[one_ring(xyz, config)], CellClass.solid, grid)


def mark(xyz: Float32[Array, "k 3"], what: CellClass, grid: GridConfig) -> UInt8[Array, "n n"]:
    """A map whose cells with points have one class; the others are free."""
    within = (xyz[:, :2] >= -grid.half_m).all(axis=1) & (xyz[:, :2] < grid.half_m).all(axis=1)
    classes = np.full((grid.cells, grid.cells), CellClass.free, np.uint8)
    classes[cell_numbers(xyz[within, 0], grid), cell_numbers(xyz[within, 1], grid)] = what
    return classes
