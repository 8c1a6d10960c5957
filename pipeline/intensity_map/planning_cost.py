"""What a trajectory costs on a planning map (MIM, eq. 12)."""

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig


def obstacle_cost(
    plan: Float32[Array, "n n"], trajectories: Float32[Array, "k p 2"], grid: GridConfig
) -> Float32[Array, " k"]:
    """The sum of the map along each of k trajectories of p points; points outside the map cost nothing.

    Args:
        plan: I_plan.
        trajectories: x and y in the frame of the grid, in metres; `roll_out` of the unicycle makes them.
        grid: Where the map's cells lie.
    """
    cell = np.floor(trajectories * np.float32(1 / grid.cell_m) + np.float32(0.5 * grid.cells)).astype(np.int64)
    row, column = cell[..., 0], cell[..., 1]
    inside = (row >= 0) & (row < grid.cells) & (column >= 0) & (column < grid.cells)
    cost = plan.ravel().take(row * grid.cells + column, mode="clip")
    return np.asarray((cost * inside).sum(axis=-1, dtype=np.float32))
