"""A way through a place that stays clear of what is solid."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from navtool.sim.drive.surroundings import Surroundings
from navtool.sim.errors import SimError

_CELL_M = 0.2
_EVERY = 3
"""Cells of the way for each of its points."""
_CLEAR_M = 0.5
"""Where it can, it keeps this far from what is solid, beside half the robot's width."""
_LEAST_M = 0.05
_NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))


def find_route(
    surroundings: Surroundings, start: tuple[float, float], goal: tuple[float, float], half_width_m: float
) -> list[tuple[float, float]]:
    """Points from start to goal: short, away from what is solid, and rather around than through what yields.

    Raises:
        SimError: There is no way for a robot of that width.
    """
    half_x, half_y = surroundings.half_extent_m
    axis_x, axis_y = np.arange(-half_x, half_x, _CELL_M), np.arange(-half_y, half_y, _CELL_M)
    x, y = np.meshgrid(axis_x, axis_y)
    free = surroundings.solid_m(x, y) - half_width_m
    cost = 1.0 + 6.0 * np.clip(1.0 - free / _CLEAR_M, 0.0, 1.0) + 2.0 * (surroundings.soft_m(x, y) < half_width_m)
    cost[free < _LEAST_M] = np.inf
    number = np.arange(x.size).reshape(x.shape)
    rows, columns, lengths = [], [], []
    for down, right in _NEIGHBOURS:
        here = number[: len(number) - down, max(0, -right) : number.shape[1] - max(0, right)].ravel()
        there = here + down * number.shape[1] + right
        length = _CELL_M * np.hypot(down, right) * 0.5 * (cost.ravel()[here] + cost.ravel()[there])
        open_ = np.isfinite(length)
        rows.append(here[open_])
        columns.append(there[open_])
        lengths.append(length[open_])
    graph = coo_array((np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), (x.size, x.size))
    ends = [int(np.hypot(x - end[0], y - end[1]).argmin()) for end in (start, goal)]
    away, before = dijkstra(graph.tocsr(), directed=False, indices=ends[1], return_predecessors=True)
    if not np.isfinite(away[ends[0]]):
        what = f"no way from start to goal for a robot of half width {half_width_m} m"
        raise SimError(what, cure="choose another seed, or a narrower robot")
    cells = [ends[0]]
    while cells[-1] != ends[1]:
        cells.append(int(before[cells[-1]]))
    between = cells[_EVERY:-_EVERY:_EVERY]
    return [start, *((float(x.flat[cell]), float(y.flat[cell])) for cell in between), goal]
