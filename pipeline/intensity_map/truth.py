"""Which cells of a grid what is known to stand in a place covers."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float64, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.obstacles import CellClass

_ORDER = (CellClass.pliable, CellClass.transparent, CellClass.solid)
"""Where outlines share a cell, a later class goes before an earlier one: as in the classes of a map."""


@dataclass(frozen=True, slots=True)
class Outline:
    """One thing that stands in a place, seen from above."""

    what: CellClass
    """Not free."""
    corners_m: Float64[Array, "k 2"]
    """x and y in a frame that does not move, in either direction around; three or more, convex or not."""

    def __post_init__(self) -> None:
        if self.what is CellClass.free:
            raise ValueError("an outline is of something: pliable, solid or transparent, not free")
        if self.corners_m.ndim != 2 or self.corners_m.shape[0] < 3 or self.corners_m.shape[1] != 2:
            raise ValueError(f"an outline has three corners or more, x and y each; got {self.corners_m.shape}")
        if not np.isfinite(self.corners_m).all():
            raise ValueError("the corners of an outline have to be finite")


def truth_classes(
    outlines: Sequence[Outline], frame_sensor: Float64[Array, "3"], grid: GridConfig
) -> UInt8[Array, "n n"]:
    """The class of each cell of the grid around a sensor; what no outline touches is free.

    A cell belongs to an outline that it touches anywhere: a pane of a centimetre is a gapless line of cells. Where
    outlines of several classes touch a cell, solid goes before transparent, and transparent before pliable.

    Args:
        outlines: What stands there.
        frame_sensor: x, y and yaw of the sensor in the frame of the outlines.
        grid: Around the sensor.
    """
    x, y, yaw = frame_sensor.tolist()
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    classes = np.full((grid.cells, grid.cells), CellClass.free, np.uint8)
    for outline in sorted(outlines, key=lambda one: _ORDER.index(one.what)):
        corners = (outline.corners_m - (x, y)) @ turn / grid.cell_m + grid.cells / 2
        low = np.maximum(np.floor(corners.min(axis=0)).astype(np.int64), 0)
        high = np.minimum(np.floor(corners.max(axis=0)).astype(np.int64) + 1, grid.cells)
        if (low < high).all():
            window = classes[low[0] : high[0], low[1] : high[1]]
            window[_touched(corners, np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)] = outline.what
    return classes


def _touched(
    corners: Float64[Array, "k 2"], rows: Float64[Array, " r"], columns: Float64[Array, " c"]
) -> Bool[Array, "r c"]:
    """Which unit squares with these middles a polygon touches: an edge meets them, or they lie within."""
    x, y = rows[:, None, None], columns[None, :, None]
    start, end = corners, np.roll(corners, -1, axis=0)
    middle, way = 0.5 * (start + end), end - start
    dx, dy = x - middle[:, 0], y - middle[:, 1]
    half = 0.5 * np.abs(way)
    # a segment and a square are apart where one of three lines divides them: the square's sides', or the segment's
    met = (np.abs(dx) <= 0.5 + half[:, 0]) & (np.abs(dy) <= 0.5 + half[:, 1])
    met &= np.abs(way[:, 0] * dy - way[:, 1] * dx) <= half.sum(axis=1)
    # even-odd rule, for squares that no edge meets
    across = (start[:, 1] > y) != (end[:, 1] > y)
    rise = np.where(way[:, 1] == 0, 1.0, way[:, 1])
    left = x < start[:, 0] + (y - start[:, 1]) * way[:, 0] / rise
    return np.asarray(met.any(axis=2) | ((across & left).sum(axis=2) % 2 == 1))
