"""What an intensity map costs a cloud, step by step, beside the way one writes it down first."""

import time
from collections.abc import Callable
from typing import Any, NamedTuple

import cv2
import numpy as np
from _report import Row, write_report
from numpy.typing import NDArray
from scipy.ndimage import label, uniform_filter
from scipy.signal import convolve2d

from navtool.pipeline.geometry.unicycle import rollout
from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass import find_glass
from navtool.pipeline.intensity_map.glass_memory import GlassMemory, remember_glass, transparent_cells
from navtool.pipeline.intensity_map.inflation import inflation_kernel, planning_map
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import intensity_layers
from navtool.pipeline.intensity_map.mapper import map_cloud
from navtool.pipeline.intensity_map.obstacles import cell_classes, find_obstacles
from navtool.pipeline.intensity_map.planning_cost import obstacle_cost

ROUNDS, CALLS = 40, 5
SIZES = ((16, 1875, 1.5), (64, 1875, 4.0))
CANDIDATES, STEPS = 50, 30
GOAL_RAD = 0.3
CONFIG = IntensityMapConfig()


class Cloud(NamedTuple):
    """Points and their intensities."""

    xyz: NDArray[np.float32]
    intensity: NDArray[np.float32]


class Times(NamedTuple):
    """Times of many calls."""

    median_s: float
    least_s: float


def main() -> None:
    cv2.setNumThreads(1)
    rows = [row for rings, columns, bar in SIZES for row in cloud_rows(scan(rings, columns), bar)]
    write_report("mim", rows)


def cloud_rows(cloud: Cloud, bar_ms: float) -> list[Row]:
    """Each step's least time beside the naive one's, and the whole, its median and its least.

    The least of many times is what a step takes where nothing disturbs it; the bar is for the median.
    """
    xyz, intensity = cloud
    grid, config = CONFIG.grid, CONFIG
    points = sort_points(xyz, intensity, grid, config.layers)
    layers = intensity_layers(points, grid, config.layers)
    obstacles = find_obstacles(layers, grid, config.layers, config.obstacles)
    solid, origin = obstacles.solid > 0, np.zeros(3)
    panes = find_glass(points, layers, solid, grid, config.glass)
    memory = remember_glass(GlassMemory(), panes, origin, 0.0, 0.4, grid, config.glass)
    transparent = transparent_cells(memory, origin, grid, config.glass)
    kernel = inflation_kernel(GOAL_RAD, config.inflation)
    plan = planning_map(obstacles, transparent, kernel)
    ways = trajectories()

    def glass() -> None:
        segments = find_glass(points, layers, solid, grid, config.glass)
        known = remember_glass(memory, segments, origin, 0.1, 0.4, grid, config.glass)
        transparent_cells(known, origin, grid, config.glass)

    def whole() -> None:
        made = map_cloud(memory, xyz, intensity, origin, 0.1, GOAL_RAD, config)[1]
        obstacle_cost(made.plan, ways, grid)

    def naive_whole() -> None:
        stacked, number = naive_layers(xyz, intensity)
        hard, soft = naive_classes(stacked, number)
        naive_glass(stacked, number)
        naive_cost(naive_plan(hard, soft, kernel), ways)

    naive = naive_layers(xyz, intensity)
    steps: list[tuple[str, Callable[[], object], Callable[[], object]]] = [
        (
            "layers",
            lambda: intensity_layers(sort_points(xyz, intensity, grid, config.layers), grid, config.layers),
            lambda: naive_layers(xyz, intensity),
        ),
        (
            "classes",
            lambda: cell_classes(find_obstacles(layers, grid, config.layers, config.obstacles), transparent),
            lambda: naive_classes(*naive),
        ),
        ("glass and its memory, against labelled weak cells alone", glass, lambda: naive_glass(*naive)),
        (
            "inflation",
            lambda: planning_map(obstacles, transparent, inflation_kernel(GOAL_RAD, config.inflation)),
            lambda: naive_plan(obstacles.solid, obstacles.pliable, kernel),
        ),
        (
            f"cost of {CANDIDATES} candidates of {STEPS} points",
            lambda: obstacle_cost(plan, ways, grid),
            lambda: naive_cost(plan, ways),
        ),
    ]
    size, calls = f"{len(xyz):,} points", CALLS * ROUNDS
    rows = []
    for name, ours, theirs in steps:
        mine, peer = take_turns(ours, theirs)
        rows.append(milliseconds(f"{size}: {name}", mine.least_s, peer.least_s))
    mine, peer = take_turns(whole, naive_whole)
    rows.append(milliseconds(f"{size}: the whole map and the cost, median", mine.median_s, peer.median_s, bar_ms))
    rows.append(milliseconds(f"{size}: the same, least of {calls}", mine.least_s, peer.least_s))
    return rows


def take_turns(*functions: Callable[[], object]) -> list[Times]:
    """Median and least time of each; they take turns, so that a busy machine slows them alike."""
    taken: list[list[float]] = [[] for _ in functions]
    for _ in range(ROUNDS):
        for function, times in zip(functions, taken, strict=True):
            function()
            for _ in range(CALLS):
                start = time.perf_counter()
                function()
                times.append(time.perf_counter() - start)
    return [Times(float(np.median(times)), min(times)) for times in taken]


def milliseconds(what: str, ours: float, peer: float, bar: float | None = None) -> Row:
    holds = bar is None or 1000 * ours <= bar
    return Row(what=what, ours=1000 * ours, peer=1000 * peer, ratio=peer / ours, unit="ms", bar=bar, holds=holds)


def scan(rings: int, columns: int) -> Cloud:
    """A turn in a round place with ground, one half of it strong, one weak, and a pane."""
    rng = np.random.default_rng(0)
    azimuth, elevation = np.meshgrid(
        np.linspace(-np.pi, np.pi, columns, endpoint=False), np.radians(np.linspace(-15, 15, rings)), indexing="ij"
    )
    reach = 6 + 3 * np.sin(3 * azimuth) + rng.normal(0, 0.02, azimuth.shape)
    strength = np.where(azimuth > 0, 0.95, 0.4) + rng.normal(0, 0.1, azimuth.shape)
    glass = (np.abs(azimuth - 0.2) < 0.1) & (np.abs(elevation) < 0.1)
    mirrored = 0.16 * (1 - 30 * ((azimuth - 0.2) ** 2 + elevation**2))
    reach, strength = np.where(glass, 3 / np.cos(azimuth - 0.2), reach), np.where(glass, mirrored, strength)
    ground = np.where(elevation < 0, 0.75 / np.maximum(-np.sin(elevation), 1e-9), np.inf)
    reach, strength = np.minimum(reach, ground), np.where(ground < reach, 0.3, strength)
    level = reach * np.cos(elevation)
    xyz = np.stack([level * np.cos(azimuth), level * np.sin(azimuth), reach * np.sin(elevation)], axis=-1)
    intensity = np.round(255 * np.clip(strength, 0, 1)).ravel()
    return Cloud(xyz.reshape(-1, 3).astype(np.float32), intensity.astype(np.float32))


def trajectories() -> NDArray[np.float32]:
    rng = np.random.default_rng(1)
    velocity = np.column_stack([rng.uniform(0, 1.5, CANDIDATES), rng.uniform(-1, 1, CANDIDATES)])
    return rollout(velocity, STEPS, 0.1)[..., :2].astype(np.float32)


def naive_layers(xyz: Any, intensity: Any) -> tuple[Any, Any]:
    """Masks and two-dimensional histograms, a layer at a time, without a look at the ground."""
    grid, config = CONFIG.grid, CONFIG.layers
    elevation = np.arctan2(xyz[:, 2], np.hypot(xyz[:, 0], xyz[:, 1]))
    within = np.abs(xyz[:, 2]) <= config.height_m
    level = within & (np.abs(elevation) <= config.flat_rad)
    below = within & (elevation < -config.flat_rad) & (elevation >= -3 * config.flat_rad)
    rest = within & ~level & ~below
    edges = np.linspace(-grid.half_m, grid.half_m, grid.cells + 1)
    total, number = [], []
    for mask in (level, below, rest & (xyz[:, 2] > 0), rest & (xyz[:, 2] < 0)):
        chosen, share = xyz[mask], intensity[mask] / config.full_scale
        total.append(np.histogram2d(chosen[:, 0], chosen[:, 1], (edges, edges), weights=share)[0])
        number.append(np.histogram2d(chosen[:, 0], chosen[:, 1], (edges, edges))[0])
    return np.stack(total), np.stack(number)


def naive_classes(total: Any, number: Any) -> tuple[Any, Any]:
    side = 2 * CONFIG.obstacles.pooling_cells + 1
    pooled = [uniform_filter(part, (0, side, side), mode="constant") for part in (total, number)]
    above = (pooled[0] / np.maximum(pooled[1], 1e-9) > CONFIG.obstacles.threshold).any(axis=0)
    highest = (total / np.maximum(number, 1)).max(axis=0)
    return np.where(above, highest, 0), np.where(above, 0, highest)


def naive_glass(total: Any, number: Any) -> int:
    mean = total / np.maximum(number, 1)
    weak = (number[0] > 0) & (mean[0] < CONFIG.glass.intensity) & (mean[0] > mean[1])
    return int(label(weak, np.ones((3, 3)))[1])


def naive_plan(hard: Any, soft: Any, kernel: Any) -> Any:
    return np.maximum(convolve2d(hard, kernel, mode="same"), soft)


def naive_cost(plan: Any, ways: Any) -> list[float]:
    grid = CONFIG.grid
    costs = []
    for way in ways:
        cost = 0.0
        for x, y in way:
            row, column = (
                int(np.floor(x / grid.cell_m + grid.cells / 2)),
                int(np.floor(y / grid.cell_m + grid.cells / 2)),
            )
            if 0 <= row < grid.cells and 0 <= column < grid.cells:
                cost += plan[row, column]
        costs.append(cost)
    return costs


if __name__ == "__main__":
    main()
