"""Obstacles grown away from the goal (MIM, eq. 8 to 11)."""

import math

import cv2
import numpy as np
from jaxtyping import Bool, Float32

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import Inflation, InflationConfig
from navtool.pipeline.intensity_map.obstacles import Obstacles

_PART = 11
"""Side of the largest kernel that OpenCV sums directly."""


def inflation_kernel(goal_rad: float, config: InflationConfig) -> Float32[Array, "e e"]:
    """K of eq. 9: 1 where an obstacle in the middle grows to, rows along x and columns along y as in the grid.

    The line of eq. 8 runs through the middle along the direction of the goal. As the text of IV-C has it, obstacles
    grow opposite to the goal: the kernel is the half of the line that points there, with its thickness, and a disc
    around the middle for the minor inflation elsewhere (docs/papers.md, eq. 8).

    Args:
        goal_rad: Direction of the goal, atan2(g_y, g_x), in the frame of the grid.
        config: Size, thickness and disc.

    Raises:
        ValueError: The direction is not finite.
    """
    if not math.isfinite(goal_rad):
        raise ValueError(f"the direction of the goal is {goal_rad} rad; it has to be finite")
    reach = (config.size_cells - 1) // 2
    if config.method is Inflation.uniform:
        return np.ones((config.size_cells, config.size_cells), np.float32)
    axis = np.arange(-reach, reach + 1, dtype=np.float64)
    x, y = axis[:, None], axis
    cosine, sine = np.cos(goal_rad), np.sin(goal_rad)
    back, aside = -(x * cosine + y * sine), np.abs(y * cosine - x * sine)
    half_line = (back > -0.5) & (aside <= config.padding_cells + 0.5)
    disc = np.hypot(x, y) <= config.minor_cells + 1e-9
    return np.asarray((half_line | disc).astype(np.float32))


def inflate(values: Float32[Array, "n n"], kernel: Float32[Array, "e e"]) -> Float32[Array, "n n"]:
    """The convolution of eq. 10; beyond the edge of the grid there is nothing.

    Where the kernel meets zeros alone the result is exactly 0: parts of the kernel are summed one by one, since OpenCV
    takes Fourier transforms for large ones, which leave crumbs everywhere and are slower for these maps.

    Raises:
        ValueError: The grid is smaller than the kernel.
    """
    n, side = values.shape[0], kernel.shape[0]
    if n < side:
        what = f"a grid of {n} cells is smaller than the inflation kernel of {side}"
        raise ValueError(f"{what}; take a larger grid or a smaller size_cells")
    reach = side // 2
    turned = kernel[::-1, ::-1].copy()  # filter2D correlates
    if side <= _PART:
        return np.asarray(cv2.filter2D(values, -1, turned, borderType=cv2.BORDER_CONSTANT), np.float32)
    around = cv2.copyMakeBorder(values, reach, reach, reach, reach, cv2.BORDER_CONSTANT)
    grown = np.zeros((n, n), np.float32)
    for row in range(0, side, _PART):
        for column in range(0, side, _PART):
            part = turned[row : row + _PART, column : column + _PART].copy()
            if part.any():
                beside = around[row : row + n + part.shape[0] - 1, column : column + n + part.shape[1] - 1]
                more = cv2.filter2D(beside, -1, part, anchor=(0, 0), borderType=cv2.BORDER_CONSTANT)
                np.add(grown, more[:n, :n], out=grown)
    return grown


def planning_map(
    obstacles: Obstacles, transparent: Bool[Array, "n n"], kernel: Float32[Array, "e e"]
) -> Float32[Array, "n n"]:
    """I_plan of eq. 11: inflated solid and transparent cells, and what yields as it is; unions take the larger value.

    Transparent cells count with R at least: the weak intensities that give them away say nothing of how hard they are.
    """
    hard = obstacles.solid.copy()
    # panes cover few cells
    panes = np.flatnonzero(transparent)
    hard.reshape(-1)[panes] = np.maximum(hard.ravel().take(panes), np.float32(1))
    grown = inflate(hard, kernel)
    return np.maximum(grown, obstacles.pliable, out=grown)
