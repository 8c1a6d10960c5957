"""Glass remembered in the odometry frame while the robot moves (MIM, eq. 6 and 7)."""

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
    forgotten, and counted as a jump, where the pose lies further than ``jump_m`` from the one before or time runs
    backwards.

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
    x, y = float(odom_sensor[0]), float(odom_sensor[1])
    if not (np.isfinite(odom_sensor).all() and np.isfinite(time_s)):
        raise ValueError(f"the sensor is at {odom_sensor} at {time_s} s: pose and time have to be finite")
    before = (x, y) if memory.position_m is None else memory.position_m
    if np.hypot(x - before[0], y - before[1]) > config.jump_m or time_s < memory.time_s:
        memory, before = GlassMemory(jumps=memory.jumps + 1), (x, y)
    covered = np.unique(_number(_in_odometry(_along(segments, grid), odom_sensor), grid))
    cell = np.concatenate([memory.cell, covered])
    clouds = np.concatenate([memory.clouds, np.ones(covered.size, np.int64)])
    seen = np.concatenate([memory.seen_s, np.full(covered.size, time_s)])
    cell, place = np.unique(cell, return_inverse=True)
    clouds = np.bincount(place, clouds, cell.size).astype(np.int64)
    latest = np.full(cell.size, -np.inf)
    np.maximum.at(latest, place, seen)
    middle = _middle(cell, grid)
    away = np.hypot(*(middle - (x, y)).T)
    kept = (latest > time_s - config.decay_s) & (away < 1.5 * grid.half_m)
    kept &= _distance_to_way(middle, before, (x, y)) > robot_radius_m
    return GlassMemory(cell[kept], clouds[kept], latest[kept], (x, y), time_s, memory.jumps)


def transparent_cells(
    memory: GlassMemory, odom_sensor: Float64[Array, "3"], grid: GridConfig, config: GlassConfig
) -> Bool[Array, "n n"]:
    """The cells of the grid around the sensor that are known to be glass (I_FN of eq. 7)."""
    mask = np.zeros((grid.cells, grid.cells), bool)
    known = memory.cell[memory.clouds >= config.clouds]
    if not known.size:
        return mask
    # A cell of one frame lies askew over those of the other: its middle and its quarters find all that it covers well.
    quarter = 0.25 * grid.cell_m
    points = (
        _middle(known, grid)[:, None]
        + np.array([(0, 0), (-quarter, -quarter), (-quarter, quarter), (quarter, -quarter), (quarter, quarter)])
    ).reshape(-1, 2)
    yaw = float(odom_sensor[2])
    cosine, sine = np.cos(yaw), np.sin(yaw)
    dx, dy = points[:, 0] - odom_sensor[0], points[:, 1] - odom_sensor[1]
    local = np.stack([cosine * dx + sine * dy, cosine * dy - sine * dx], axis=1)
    cell = np.floor(local / grid.cell_m + grid.cells / 2).astype(np.int64)
    row, column = cell[((cell >= 0) & (cell < grid.cells)).all(axis=1)].T
    mask[row, column] = True
    return mask


def _along(segments: Float32[Array, "s 4"], grid: GridConfig) -> Float64[Array, "m 2"]:
    """Points along segments, two a cell."""
    parts = [np.zeros((0, 2))]
    for x0, y0, x1, y1 in segments.astype(np.float64).tolist():
        count = int(np.ceil(2 * np.hypot(x1 - x0, y1 - y0) / grid.cell_m)) + 1
        parts.append(np.linspace((x0, y0), (x1, y1), count))
    return np.concatenate(parts)


def _distance_to_way(
    points: Float64[Array, "k 2"], start: tuple[float, float], end: tuple[float, float]
) -> Float64[Array, " k"]:
    """How far points lie from the straight way between two positions."""
    way = np.subtract(end, start)
    from_start = points - start
    share = np.clip(from_start @ way / max(float(way @ way), 1e-12), 0.0, 1.0)
    return np.asarray(np.hypot(*(from_start - share[:, None] * way).T))


def _in_odometry(points: Float64[Array, "m 2"], odom_sensor: Float64[Array, "3"]) -> Float64[Array, "m 2"]:
    x, y, yaw = odom_sensor.tolist()
    cosine, sine = np.cos(yaw), np.sin(yaw)
    return np.asarray(points @ np.array([[cosine, sine], [-sine, cosine]]) + (x, y))


def _number(points: Float64[Array, "m 2"], grid: GridConfig) -> Int64[Array, " m"]:
    cell = np.floor(points / grid.cell_m).astype(np.int64) + _OFFSET
    return np.asarray((cell[:, 0] << 31) | cell[:, 1])


def _middle(cell: Int64[Array, " k"], grid: GridConfig) -> Float64[Array, "k 2"]:
    index = np.stack([cell >> 31, cell & ((1 << 31) - 1)], axis=1) - _OFFSET
    return np.asarray((index + 0.5) * grid.cell_m)
