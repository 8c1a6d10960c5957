"""An occupancy grid: log odds of cells that beams end in and pass through, kept while the robot moves."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Float64, Int64, UInt8

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.layer_points import LayerPoints
from navtool.pipeline.intensity_map.obstacles import CellClass


@dataclass(kw_only=True, slots=True)
class OccupancyConfig:
    """What a beam adds to the log odds of a cell."""

    hit: float = 0.85
    """Where it ends, above 0: a probability of 0.7."""
    miss: float = -0.41
    """Where it passes, below 0: a probability of 0.4."""
    highest: float = 3.5
    """No cell goes above, so that it can change again; above 0."""
    lowest: float = -2.0
    """No cell goes below; below 0."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, self.highest, "hit", above=True, cure="give at most highest"),
            outside(self, self.lowest, 0, "miss", below=True, cure="give at least lowest"),
        )


class OccupancyGrid(NamedTuple):
    """Cells along the axes of the odometry frame, which reach as far as the corners of a grid around the sensor."""

    log_odds: Float32[Array, "w w"]
    """Above 0: more likely occupied than not; 0: unknown."""
    corner: tuple[int, int]
    """The number of the first cell in the odometry frame."""


def occupancy_grid(grid: GridConfig) -> OccupancyGrid:
    """A grid that knows nothing, around the origin of the odometry frame."""
    side = 2 * math.ceil(grid.cells / math.sqrt(2))
    return OccupancyGrid(np.zeros((side, side), np.float32), (-side // 2, -side // 2))


def observe(
    before: OccupancyGrid,
    points: LayerPoints,
    odom_sensor: Float64[Array, "3"],
    grid: GridConfig,
    config: OccupancyConfig,
) -> OccupancyGrid:
    """The grid after another cloud; what it was is left as it is.

    A cloud counts once for each cell, however many of its beams meet it, and a beam's end counts more than another one
    that passes. Only beams that end in a layer count: those that meet the ground may have passed above what stands
    before it.

    Args:
        before: What was known.
        points: Of the cloud, sorted into layers; their intensities do not matter.
        odom_sensor: x, y and yaw of the sensor in the odometry frame.
        grid: Around the sensor.
        config: What a beam adds.
    """
    x, y, yaw = odom_sensor.tolist()
    side = before.log_odds.shape[0]
    corner = (math.floor(x / grid.cell_m) - side // 2, math.floor(y / grid.cell_m) - side // 2)
    log_odds = _moved(before, corner)
    local = np.stack([points.x, points.y], axis=1).astype(np.float64)
    cosine, sine = math.cos(yaw), math.sin(yaw)
    ends = (local @ np.array([[cosine, sine], [-sine, cosine]]) + (x, y)) / grid.cell_m - corner
    cell = np.clip(np.floor(ends).astype(np.int64), 0, side - 1)
    hit = np.unique(cell[:, 0] * side + cell[:, 1])
    middle = np.stack([hit // side, hit % side], axis=1) + 0.5
    passed = np.setdiff1d(passed_cells(np.array((x, y)) / grid.cell_m - corner, middle, side), hit)
    log_odds.reshape(-1)[hit] += np.float32(config.hit)
    log_odds.reshape(-1)[passed] += np.float32(config.miss)
    np.clip(log_odds, config.lowest, config.highest, out=log_odds)
    return OccupancyGrid(log_odds, corner)


def occupancy_classes(known: OccupancyGrid, odom_sensor: Float64[Array, "3"], grid: GridConfig) -> UInt8[Array, "n n"]:
    """The class of each cell around the sensor: solid where it is more likely occupied than not, else free."""
    x, y, yaw = odom_sensor.tolist()
    axis = (np.arange(grid.cells) + 0.5 - grid.cells / 2) * grid.cell_m
    ahead, left = np.meshgrid(axis, axis, indexing="ij")
    row = np.floor((x + math.cos(yaw) * ahead - math.sin(yaw) * left) / grid.cell_m).astype(np.int64) - known.corner[0]
    column = np.floor((y + math.sin(yaw) * ahead + math.cos(yaw) * left) / grid.cell_m).astype(np.int64)
    column -= known.corner[1]
    side = known.log_odds.shape[0]
    within = (row >= 0) & (row < side) & (column >= 0) & (column < side)
    occupied = known.log_odds[np.clip(row, 0, side - 1), np.clip(column, 0, side - 1)] > 0
    return np.where(within & occupied, np.uint8(CellClass.solid), np.uint8(CellClass.free))


def _moved(before: OccupancyGrid, corner: tuple[int, int]) -> Float32[Array, "w w"]:
    """The same cells in a grid with another corner; what is new is unknown."""
    side = before.log_odds.shape[0]
    moved = np.zeros_like(before.log_odds)
    step = (corner[0] - before.corner[0], corner[1] - before.corner[1])
    if max(abs(step[0]), abs(step[1])) < side:
        source = tuple(slice(max(k, 0), side + min(k, 0)) for k in step)
        target = tuple(slice(max(-k, 0), side - max(k, 0)) for k in step)
        moved[target] = before.log_odds[source]
    return moved


def passed_cells(start: Float64[Array, "2"], ends: Float64[Array, "k 2"], side: int) -> Int64[Array, " m"]:
    """The cells that straight lines to the ends pass through, found at steps of a third of a cell."""
    way = ends - start
    steps = np.ceil(3 * np.hypot(way[:, 0], way[:, 1])).astype(np.int64)
    line = np.repeat(np.arange(len(ends)), steps)
    share = (np.arange(line.size) - np.repeat(np.cumsum(steps) - steps, steps)) / np.maximum(steps[line], 1)
    cell = np.floor(start + share[:, None] * way[line]).astype(np.int64)
    return np.asarray(np.unique(np.clip(cell[:, 0], 0, side - 1) * side + np.clip(cell[:, 1], 0, side - 1)))
