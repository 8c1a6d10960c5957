"""Panes of glass, found from the weak patch that beams leave where they meet a pane at right angles (MIM, eq. 6)."""

import math

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Int32, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GlassConfig, GridConfig
from navtool.pipeline.intensity_map.layer_points import Layer, LayerPoints, cell_numbers
from navtool.pipeline.intensity_map.layers import IntensityLayers

_NEIGHBOURS = np.ones((3, 3), np.uint8)
_CLEARLY = 1.5
"""A point so many times as strong as the limit for glass is of no pane: the middle of one may exceed the limit."""


def find_glass(
    points: LayerPoints,
    layers: IntensityLayers,
    solid: Bool[Array, "n n"],
    grid: GridConfig,
    config: GlassConfig,
) -> Float32[Array, "k 4"]:
    """The panes that a cloud shows, as segments x0, y0, x1, y1 in the frame of the sensor, in metres.

    A pane mirrors a beam back only where it meets it within a few degrees of its normal, and weakly. There the layer
    z = 0 is stronger than z = -epsilon (the difference of eq. 6 is positive), nothing else is in or beside the cells,
    and the points lie on a short line across the beams. Grass and curtains are as weak, but deep, anyhow or mixed.

    Args:
        points: The cloud's, sorted into layers.
        layers: Of the same points.
        solid: The solid cells: they end what is extended.
        grid: As for the layers.
        config: Limits.
    """
    level = grid.cells * grid.cells * (int(Layer.level) + 1)
    weak = np.flatnonzero((points.cell < level) & (points.share < np.float32(config.intensity)))
    weak = weak.take(np.flatnonzero(_stronger_at_level(layers, points.cell.take(weak), config)))
    if weak.size < config.points:
        return np.zeros((0, 4), np.float32)
    place = points.cell.take(weak)
    patches = _patches(place, grid)
    label = patches.take(place)
    count = np.bincount(label)
    large = count >= config.points
    if not large.any():
        return np.zeros((0, 4), np.float32)
    lines = []
    # few patches have so many points
    for patch in np.flatnonzero(large & ~_mixed(points, patches, count, solid, config)):
        member = weak.take(np.flatnonzero(label == patch))
        line = _line(np.array([points.x.take(member), points.y.take(member)], np.float64).T, config)
        if line is not None:
            lines.append(line)
    return _extended(np.array(lines, np.float32).reshape(-1, 4), solid, grid, config)


def _patches(cell: Int64[Array, " k"], grid: GridConfig) -> Int32[Array, " cells"]:
    """The number of the patch that each cell of the grid is in or beside, from 1 on; 0 is no patch.

    Cells that touch, or have one or two cells between them, are of one patch. A last number, 0, stands for whatever is
    no cell of the grid.
    """
    n = grid.cells
    mask = np.zeros((n, n), np.uint8)
    mask.reshape(-1)[cell] = 1
    column, row, width, height = cv2.boundingRect(mask)
    # a cell more on each side
    box = slice(max(row - 1, 0), row + height + 1), slice(max(column - 1, 0), column + width + 1)
    patches = np.zeros(n * n + 1, np.int32)
    _, patches[:-1].reshape(n, n)[box] = cv2.connectedComponents(cv2.dilate(mask[box], _NEIGHBOURS), connectivity=8)
    return patches


def _mixed(
    points: LayerPoints,
    patches: Int32[Array, " cells"],
    count: Int64[Array, " patches"],
    solid: Bool[Array, "n n"],
    config: GlassConfig,
) -> Bool[Array, " patches"]:
    """Which patches lie among clearly stronger points of the layer z = 0 that are not solid: curtains, grass.

    A pane is weak all along, while a string that fills part of a beam only is as weak beside stronger ones.
    """
    # few points are in or beside a patch; those of the other layers get the last number, which is 0
    label = patches.take(points.cell, mode="clip")
    near = np.flatnonzero(label > 0)
    strong = points.share.take(near) >= np.float32(_CLEARLY * config.intensity)
    strong &= ~solid.ravel().take(points.cell.take(near))
    beside = np.bincount(label.take(near[strong]), minlength=count.size)
    return np.asarray(beside >= config.mixed * count)


def _stronger_at_level(layers: IntensityLayers, cells: Int64[Array, " k"], config: GlassConfig) -> Bool[Array, " k"]:
    """In which cells z = 0 is weak but stronger than z = -epsilon: the positive part of the difference of eq. 6."""
    total, points = (
        [part[layer].ravel().take(cells) for layer in (Layer.level, Layer.below)]
        for part in (layers.total, layers.points)
    )
    weak = total[0] < np.float32(config.intensity) * points[0]
    # means are compared without a division: a / b > c / d is a d > c b
    return np.asarray(weak & ((points[1] == 0) | (total[0] * points[1] > total[1] * points[0])))


def _line(points: Float64[Array, "k 2"], config: GlassConfig) -> tuple[float, float, float, float] | None:
    """The ends of a patch that is thin and faces the sensor, None of another.

    The eigenvalues of the points' covariance are the squares of the deviations along the patch and across it.
    """
    middle = points.sum(axis=0) / len(points)
    around = points - middle
    (xx, xy), (_, yy) = (around.T @ around / len(points)).tolist()
    apart = math.hypot(xx - yy, 2 * xy)  # the difference of the eigenvalues; their sum is the trace
    across, length = math.sqrt(max(xx + yy - apart, 0.0) / 2), math.sqrt((xx + yy + apart) / 2)
    if not across < config.thickness_m < length:
        return None
    angle = 0.5 * math.atan2(2 * xy, xx - yy)
    along = np.array([math.cos(angle), math.sin(angle)])
    # the part of the beam along the patch is the sine of its incidence
    slant = abs(float(along @ middle)) / max(math.hypot(*middle.tolist()), 1e-9)
    if slant >= math.sin(config.incidence_rad):
        return None
    reach = around @ along
    (x0, y0), (x1, y1) = (middle + reach.min() * along).tolist(), (middle + reach.max() * along).tolist()
    return x0, y0, x1, y1


def _extended(
    lines: Float32[Array, "s 4"], solid: Bool[Array, "n n"], grid: GridConfig, config: GlassConfig
) -> Float32[Array, "s 4"]:
    """Each line made longer at both ends, up to the first solid cell."""
    if not len(lines) or config.extend_m == 0:
        return lines
    tips = lines.reshape(-1, 2, 2)
    outwards = tips - tips[:, ::-1]
    outwards /= np.maximum(np.hypot(outwards[..., 0], outwards[..., 1]), np.float32(1e-6))[..., None]
    step = np.float32(grid.cell_m / 2)
    steps = np.arange(1, round(2 * config.extend_m / grid.cell_m) + 1, dtype=np.float32) * step
    reached = cell_numbers(tips[:, :, None] + steps[:, None] * outwards[:, :, None], grid)  # [s, 2, steps, 2]
    open_so_far = np.logical_and.accumulate(~solid[reached[..., 0], reached[..., 1]], axis=2)
    ends = tips + (open_so_far.sum(axis=2) * step)[..., None] * outwards
    return np.asarray(ends.reshape(-1, 4), np.float32)
