"""The points around chosen points of a LiDAR cloud: by ring and azimuth where it has rings, else by a k-d tree."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int64, Integer
from numpy.lib.stride_tricks import sliding_window_view

from navtool.pipeline.arrays import Array

_AZIMUTH_CELLS = 720
_RING_STEP_RAD = np.radians(1.3)
_LEVEL_RAD = np.radians(4.0)
_LEVEL_POINTS = 1000
_WINDOW_ROWS = 2
_WINDOW_COLUMNS = 6
_MOST_RINGS = 512
_FAR_M = 1e18
"""Where the points of empty cells are put: out of everyone's reach, and their squares are still numbers."""


class Neighbourhoods(NamedTuple):
    """Chosen points of a cloud and the points around each."""

    centre: Int64[Array, " m"]
    """Index of each chosen point in the cloud."""
    difference: Float32[Array, "3 m k"]
    """Neighbour minus centre in metres, x, y and z apart; 0 for the centre itself and where there is no neighbour."""
    size: Int64[Array, " m"]
    """Number of neighbours of each."""


def rings_are_level(columns: Float32[Array, "3 n"], ring: Integer[Array, " n"]) -> bool:
    """Whether the rings are those of a spinning LiDAR: most points within 4 degrees of their ring's mean elevation.

    The lines of a LiDAR that draws rosettes are numbered like rings, and are none; nor are more than 512 numbers, which
    no LiDAR has. About 1000 points are looked at.

    Args:
        columns: x, y, z in the sensor's frame, all of them real returns, at least one.
        ring: Ring of each point, in any numbering.
    """
    if len(_numbers(ring)) > _MOST_RINGS:
        return False
    stride = max(1, columns.shape[1] // _LEVEL_POINTS)
    x, y, z = columns[:, ::stride]
    number = ring[::stride].astype(np.int64)
    elevation = np.arctan2(z, np.sqrt(x * x + y * y))
    mean = np.bincount(number, elevation) / np.maximum(np.bincount(number), 1)
    level = np.count_nonzero(np.abs(elevation - mean[number]) <= _LEVEL_RAD)
    return 2 * level > len(number)


def ring_neighbourhoods(
    columns: Float32[Array, "3 n"], ring: Integer[Array, " n"], reach: float, max_points: int
) -> Neighbourhoods:
    """The neighbours in a window along ring and azimuth of up to `max_points` points, evenly spread over the cloud.

    The cloud is laid on a grid of azimuth cells of 0.5 degrees (the last point of a cell stays) and of rings at least
    1.3 degrees apart, so that a window of 5 rings and 13 cells is about as high as wide for any sensor. Of the points
    in the window those count that are within `reach` times the centre's distance from the sensor: a window alone mixes
    what stands in front with what stands behind it.

    Args:
        columns: x, y, z in the sensor's frame, all of them real returns.
        ring: Ring of each point, in any numbering; the rings' elevations follow from the points.
        reach: Radius of a neighbourhood as a share of the centre's distance.
        max_points: Number of points to choose at most; every k-th cell with a point is chosen.
    """
    grid = _ring_grid(columns, ring)
    inner = grid.point[_WINDOW_ROWS:-_WINDOW_ROWS, _WINDOW_COLUMNS:-_WINDOW_COLUMNS]
    filled = np.flatnonzero(inner != grid.empty)
    filled = filled[:: _stride(len(filled), max_points)]
    row, column = filled // _AZIMUTH_CELLS, filled % _AZIMUTH_CELLS
    # A window of coordinates is a few short runs of numbers, not a search for each of its points.
    windows = sliding_window_view(grid.columns, 2 * _WINDOW_ROWS + 1, axis=1)
    windows = sliding_window_view(windows, 2 * _WINDOW_COLUMNS + 1, axis=2)
    around = windows[:, row, column].reshape(3, len(filled), -1)
    centre = inner[row, column]
    middle = columns[:, centre]
    around -= middle[:, :, None]
    limit = reach * reach * np.einsum("im,im->m", middle, middle)
    # As numbers: a product with truth values takes three times as long, and so does counting them.
    near = (np.einsum("imk,imk->mk", around, around) <= limit[:, None]).astype(np.float32)
    around *= near
    return Neighbourhoods(centre, around, np.einsum("mk->m", near).astype(np.int64) - 1)


def nearest_neighbourhoods(columns: Float32[Array, "3 n"], neighbours: int, max_points: int) -> Neighbourhoods:
    """The `neighbours` nearest points of up to `max_points` points, every k-th of the cloud."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - takes 0.25 s, and only clouds without rings need it

    points = columns.T
    count = points.shape[0]
    centre = np.arange(0, count, max(1, -(-count // max_points)))
    _, around = cKDTree(points, balanced_tree=False, compact_nodes=False).query(points[centre], k=neighbours + 1)
    difference = columns.take(np.asarray(around), axis=1) - columns[:, centre, None]
    return Neighbourhoods(centre, difference, np.count_nonzero(around != centre[:, None], axis=1))


class _RingGrid(NamedTuple):
    """A cloud on a grid of rings, lowest first, and azimuth cells, with a border as wide as a window reaches.

    The border repeats the cells across the azimuth's seam; above and below it is empty.
    """

    point: Int64[Array, "rows cells"]
    """The point of each cell, `empty` where there is none."""
    columns: Float32[Array, "3 rows cells"]
    """Its coordinates, those of a place out of reach where there is none."""
    empty: int


def _ring_grid(columns: Float32[Array, "3 n"], ring: Integer[Array, " n"]) -> _RingGrid:
    x, y, _ = columns
    turn = (np.arctan2(y, x) + np.float32(np.pi)) * np.float32(_AZIMUTH_CELLS / (2 * np.pi))
    column = np.minimum(turn, np.float32(_AZIMUTH_CELLS - 1)).astype(np.int64)
    rings = _numbers(ring)
    width = _AZIMUTH_CELLS + 2 * _WINDOW_COLUMNS
    first_cell = np.zeros(int(rings[-1]) + 1, np.int64)
    first_cell[rings] = np.arange(len(rings)) * width + _WINDOW_COLUMNS
    # Empty cells hold a point of their own, out of everyone's reach; a last row has nothing else.
    empty = len(x)
    points = np.append(columns, np.full((3, 1), _FAR_M, np.float32), axis=1)
    index = np.full((len(rings) + 1, width), empty, np.int64)
    index.reshape(-1)[first_cell.take(ring) + column] = np.arange(empty)
    index[:, :_WINDOW_COLUMNS] = index[:, -2 * _WINDOW_COLUMNS : -_WINDOW_COLUMNS]
    index[:, -_WINDOW_COLUMNS:] = index[:, _WINDOW_COLUMNS : 2 * _WINDOW_COLUMNS]
    on_grid = points.take(index, axis=1, mode="clip")  # all are inside: clipping takes half the time of checking
    rows = _rows(on_grid[:, :, _WINDOW_COLUMNS:-_WINDOW_COLUMNS], index[:, _WINDOW_COLUMNS:-_WINDOW_COLUMNS] < empty)
    border = [len(rings)] * _WINDOW_ROWS
    framed = border + rows + border
    return _RingGrid(index.take(framed, axis=0), on_grid.take(framed, axis=1), empty)


def _numbers(ring: Integer[Array, " n"]) -> Int64[Array, " rings"]:
    """The numbers that rings have, ascending; where all are small, those that are not used are among them."""
    most = int(ring.max())
    return np.arange(most + 1) if most < _MOST_RINGS else np.flatnonzero(np.bincount(ring))


def _rows(on_grid: Float32[Array, "3 rows cells"], filled: Bool[Array, "rows cells"]) -> list[int]:
    """The rows with points, lowest first, without those too close to the one below."""
    x, y, z = on_grid
    share = filled.astype(np.float32)
    level, up = (np.einsum("rc,rc->r", part, share) for part in (np.sqrt(x * x + y * y), z))
    elevation, there = np.arctan2(up, level), np.count_nonzero(filled, axis=1)
    rows: list[int] = []
    for row in np.argsort(elevation, kind="stable").tolist():
        # A little less than the step: rings exactly a step apart all stay.
        if there[row] and (not rows or elevation[row] - elevation[rows[-1]] > 0.98 * _RING_STEP_RAD):
            rows.append(row)
    return rows


def _stride(count: int, most: int) -> int:
    """A stride that leaves at most so many of the cells; not in step with the columns, so rows differ in theirs."""
    stride = max(1, -(-count // most))
    while math.gcd(stride, _AZIMUTH_CELLS) > 1:
        stride += 1
    return stride
