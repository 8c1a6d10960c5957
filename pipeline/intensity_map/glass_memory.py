"""Glass remembered in the odometry frame while the robot moves (MIM, eq. 6 and 7)."""

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Float32, Float64, Int64

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GlassConfig, GridConfig

_OFFSET = 1 << 30
"""Cells of the odometry frame count from here, so that their numbers are positive."""


@dataclass(frozen=True, slots=True)
class GlassMemory:
    """Cells of the odometry frame that patches of glass have covered. Begin with ``GlassMemory()``."""

    cell: Int64[Array, " k"] = field(default_factory=lambda: np.zeros(0, np.int64))
    """Numbers of cells, increasing."""
    clouds: Int64[Array, " k"] = field(default_factory=lambda: np.zeros(0, np.int64))
    """How many clouds have shown glass there."""
    seen_s: Float64[Array, " k"] = field(default_factory=lambda: np.zeros(0))
    """When the last one did."""
    position_m: tuple[float, float] | None = None
    """Where the sensor was last."""
    time_s: float = -np.inf
    """When it was there."""
    jumps: int = 0
    """How often the odometry or its clock has jumped, so that everything was forgotten."""


def remember_glass(
    memory: GlassMemory,
    segments: Float32[Array, "s 4"],
    odom_sensor: Float64[Array, "3"],
    time_s: float,
    robot_radius_m: float,
    grid: GridConfig,
    config: GlassConfig,
) -> GlassMemory:
    """The memory after another cloud; the old one is left as it is.

    Kept is what was seen within ``decay_s`` and lies within the reach of the grid. Where the robot stands there is no
    glass: only its own way clears cells, since beams that return from behind a pane have passed through it. All is
    forgotten, and counted as a jump, where the pose lies further than ``jump_m`` from where the robot can be since the
    one before, or time runs backwards.

    Args:
        memory: What was known.
        segments: Panes that the cloud shows, frame of the sensor.
        odom_sensor: x, y and yaw of the sensor in the odometry frame.
        time_s: Of the cloud.
        robot_radius_m: How far the robot reaches around the sensor.
        grid: Around the sensor; its cells' size is the memory's too.
        config: How long and from how many clouds on.

    Raises:
        ValueError: Pose or time are not finite.
    """
    x, y, yaw = odom_sensor.tolist()
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(yaw) and math.isfinite(time_s)):
        raise ValueError(f"the sensor is at {odom_sensor} at {time_s} s: pose and time have to be finite")
    before = (x, y) if memory.position_m is None else memory.position_m
    reach_m = config.jump_m + config.fastest_mps * (time_s - memory.time_s)
    if math.hypot(x - before[0], y - before[1]) > reach_m or time_s < memory.time_s:
        memory, before = GlassMemory(jumps=memory.jumps + 1), (x, y)
    cell, clouds, latest = memory.cell, memory.clouds, memory.seen_s
    if len(segments):
        shown = np.unique(_covered(segments, odom_sensor, grid))  # once for a cell, however often it is named
        cell = np.union1d(cell, shown)
        known, now = np.searchsorted(cell, memory.cell), np.searchsorted(cell, shown)
        clouds, latest = np.zeros(cell.size, np.int64), np.full(cell.size, time_s)
        clouds[known], latest[known] = memory.clouds, memory.seen_s
        clouds[now] += 1
        latest[now] = time_s
    if cell.size:
        middle = _middle(cell, grid)
        away = middle - (x, y)
        kept = (latest > time_s - config.decay_s) & (np.hypot(away[:, 0], away[:, 1]) < 1.5 * grid.half_m)
        kept &= _distance_to_way(middle, before, (x, y)) > robot_radius_m
        cell, clouds, latest = cell[kept], clouds[kept], latest[kept]
    return GlassMemory(cell, clouds, latest, (x, y), time_s, memory.jumps)


def transparent_cells(
    memory: GlassMemory, odom_sensor: Float64[Array, "3"], grid: GridConfig, config: GlassConfig
) -> Bool[Array, "n n"]:
    """The cells of the grid around the sensor that are known to be glass (I_FN of eq. 7)."""
    mask = np.zeros((grid.cells, grid.cells), bool)
    known = memory.cell[memory.clouds >= config.clouds]
    if not known.size:
        return mask
    # A cell of one frame lies askew over those of the other: its middle and its quarters find all that it covers well.
    quarters = 0.25 * grid.cell_m * np.array([[0, 0], [-1, -1], [-1, 1], [1, -1], [1, 1]])
    x, y, yaw = odom_sensor.tolist()
    local = _turned((_middle(known, grid)[:, None] + quarters - (x, y)).reshape(-1, 2), -yaw)
    row, column = np.floor(local.T / grid.cell_m + grid.cells / 2).astype(np.int64)
    inside = (row >= 0) & (row < grid.cells) & (column >= 0) & (column < grid.cells)
    mask[row[inside], column[inside]] = True
    return mask


def _covered(segments: Float32[Array, "s 4"], odom_sensor: Float64[Array, "3"], grid: GridConfig) -> Int64[Array, " m"]:
    """The numbers of the cells that segments cover, some of them repeatedly: two points a cell are looked at."""
    x, y, yaw = odom_sensor.tolist()
    parts = []
    for begin, end in segments.astype(np.float64).reshape(-1, 2, 2):
        way = end - begin
        steps = max(math.ceil(2 * math.hypot(*way.tolist()) / grid.cell_m), 1)
        parts.append(begin + np.arange(steps + 1)[:, None] / steps * way)
    places = _turned(np.concatenate(parts), yaw) + np.array([x, y])
    row, column = np.floor(places.T / grid.cell_m).astype(np.int64) + _OFFSET
    return np.asarray((row << 31) | column)


def _turned(points: Float64[Array, "k 2"], angle_rad: float) -> Float64[Array, "k 2"]:
    """Points turned about the origin, counter-clockwise."""
    cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
    return np.asarray(points @ np.array([[cosine, sine], [-sine, cosine]]))


def _distance_to_way(
    points: Float64[Array, "k 2"], start: tuple[float, float], end: tuple[float, float]
) -> Float64[Array, " k"]:
    """How far points lie from the straight way between two positions."""
    from_start, way = points - start, np.subtract(end, start)
    square = float(way @ way)
    if square > 1e-12:
        share = np.clip(from_start @ way / square, 0.0, 1.0)
        from_start = from_start - share[:, None] * way
    return np.asarray(np.hypot(from_start[:, 0], from_start[:, 1]))


def _middle(cell: Int64[Array, " k"], grid: GridConfig) -> Float64[Array, "k 2"]:
    """The middles of cells in the odometry frame."""
    number = np.array([cell >> 31, cell & ((1 << 31) - 1)]).T
    return np.asarray((number - (_OFFSET - 0.5)) * grid.cell_m)
