"""The points around chosen points of a LiDAR cloud: by ring and azimuth where it has rings, else by a k-d tree."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Int64, Integer
from numpy.lib.stride_tricks import sliding_window_view

from navtool.pipeline.arrays import Array

_AZIMUTH_CELLS = 720
_RING_STEP_RAD = np.radians(1.3)
_LEVEL_RAD = np.radians(4.0)
_LEVEL_POINTS = 1000
_WINDOW_ROWS = 2
_WINDOW_COLUMNS = 6
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

    The lines of a LiDAR that draws rosettes are numbered like rings, and are none. About 1000 points are looked at.

    Args:
        columns: x, y, z in the sensor's frame, all of them real returns, at least one.
        ring: Ring of each point, in any numbering.
    """
    stride = max(1, columns.shape[1] // _LEVEL_POINTS)
    x, y, z = columns[:, ::stride]
    number = ring[::stride].astype(np.int64)
    elevation = np.arctan2(z, np.sqrt(x * x + y * y))
    mean = np.bincount(number, elevation) / np.maximum(np.bincount(number), 1)
    return bool(np.median(np.abs(elevation - mean[number])) <= _LEVEL_RAD)


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
    x, y, z = columns
    number = ring.astype(np.int64)
    row_of_ring, rows = _rows(number, z, np.sqrt(x * x + y * y))
    turn = (np.arctan2(y, x) + np.float32(np.pi)) * np.float32(_AZIMUTH_CELLS / (2 * np.pi))
    column = np.minimum(turn.astype(np.int64), _AZIMUTH_CELLS - 1)
    # A border around the cells, which repeats them across the azimuth's seam, and a last row for the rings left out.
    width = _AZIMUTH_CELLS + 2 * _WINDOW_COLUMNS
    index = np.full((rows + 2 * _WINDOW_ROWS + 1, width), -1, np.int64)
    index.reshape(-1)[row_of_ring[number] * width + column + _WINDOW_COLUMNS] = np.arange(len(x))
    inner = index[:-1, _WINDOW_COLUMNS:-_WINDOW_COLUMNS].copy()
    index[:-1, :_WINDOW_COLUMNS] = inner[:, -_WINDOW_COLUMNS:]
    index[:-1, -_WINDOW_COLUMNS:] = inner[:, :_WINDOW_COLUMNS]
    filled = np.flatnonzero(inner.reshape(-1) >= 0)
    filled = filled[:: _stride(len(filled), max_points)]
    at_row, at_column = filled // _AZIMUTH_CELLS, filled % _AZIMUTH_CELLS
    # Coordinates on the grid: a window is then a few short runs of numbers, not a search for each of its points.
    grids = np.append(columns, np.full((3, 1), _FAR_M, np.float32), axis=1).take(index, axis=1)
    windows = sliding_window_view(grids, 2 * _WINDOW_ROWS + 1, axis=1)
    windows = sliding_window_view(windows, 2 * _WINDOW_COLUMNS + 1, axis=2)
    around = windows[:, at_row - _WINDOW_ROWS, at_column].reshape(3, len(filled), -1)
    centre = inner[at_row, at_column]
    middle = columns[:, centre]
    around -= middle[:, :, None]
    limit = reach * reach * np.einsum("im,im->m", middle, middle)
    near = np.einsum("imk,imk->mk", around, around) <= limit[:, None]
    around *= near
    return Neighbourhoods(centre, around, np.count_nonzero(near, axis=1) - 1)


def nearest_neighbourhoods(columns: Float32[Array, "3 n"], neighbours: int, max_points: int) -> Neighbourhoods:
    """The `neighbours` nearest points of up to `max_points` points, every k-th of the cloud."""
    from scipy.spatial import cKDTree  # noqa: PLC0415 - takes 0.25 s, and only clouds without rings need it

    points = columns.T
    count = points.shape[0]
    centre = np.arange(0, count, max(1, -(-count // max_points)))
    _, around = cKDTree(points, balanced_tree=False, compact_nodes=False).query(points[centre], k=neighbours + 1)
    difference = columns.take(np.asarray(around), axis=1) - columns[:, centre, None]
    return Neighbourhoods(centre, difference, np.count_nonzero(around != centre[:, None], axis=1))


def _rows(
    ring: Int64[Array, " n"], z: Float32[Array, " n"], level: Float32[Array, " n"]
) -> tuple[Int64[Array, " rings"], int]:
    """The grid row of each ring, lowest first, the last one for rings too close to another, and the number of rows."""
    count = np.bincount(ring)
    elevation = np.arctan2(np.bincount(ring, z), np.bincount(ring, level))
    row_of_ring = np.full(len(count), -1, np.int64)
    rows, last = 0, -np.inf
    for index in np.argsort(elevation, kind="stable").tolist():
        # A little less than the step: rings exactly a step apart all stay.
        if count[index] and elevation[index] - last > 0.98 * _RING_STEP_RAD:
            row_of_ring[index] = rows + _WINDOW_ROWS
            rows, last = rows + 1, elevation[index]
    row_of_ring[row_of_ring < 0] = rows + 2 * _WINDOW_ROWS
    return row_of_ring, rows


def _stride(count: int, most: int) -> int:
    """A stride that leaves at most so many of the cells; not in step with the columns, so rows differ in theirs."""
    stride = max(1, -(-count // most))
    while math.gcd(stride, _AZIMUTH_CELLS) > 1:
        stride += 1
    return stride
