"""The intensity map and its peers on the same clouds, scored over the same cells."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from _mim_drives import Cloud, Place, clouds, drive_through
from _mim_glass import FalseGlass
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.layer_points import LayerPoints, sort_points
from navtool.pipeline.intensity_map.mapper import map_cloud
from navtool.pipeline.intensity_map.peers.height_difference import HeightDifferenceConfig, height_difference_map
from navtool.pipeline.intensity_map.peers.intensity_peaks import IntensityPeakConfig, intensity_peak_map
from navtool.pipeline.intensity_map.peers.laser_scan_map import LaserScanConfig, laser_scan_map
from navtool.pipeline.intensity_map.peers.occupancy_grid import (
    OccupancyConfig,
    observe,
    occupancy_classes,
    occupancy_grid,
)
from navtool.pipeline.intensity_map.score import Counts, compare, no_counts, observed_cells, passed_over
from navtool.pipeline.intensity_map.truth import truth_classes
from navtool.sim.world.scenario import Split

OURS = "MIM"
SCORED_EVERY = 4
"""Share of clouds that is scored: all ten a second are mapped, every fourth is judged; the next are nearly the same."""
ALL_PASSED = "MIM, cells behind the nearest return too"
"""The same map over all cells that any beam passes over: what a beam over a bush says of it counts as well."""

TWO_CELLS = "MIM, with a tolerance of two cells"


@dataclass
class Drive:
    """What the methods came to on one drive."""

    counts: dict[str, Counts] = field(default_factory=dict)
    false_glass: int = 0
    """Panes claimed where the place has none at all; 0 where it has."""
    clouds: int = 0
    scored: int = 0
    seconds: float = 0.0
    moved_m: float = 0.0


def judge_drive(
    scenario: str, split: Split, seed: int, seconds: float, config: IntensityMapConfig, *, scored: bool = True
) -> Drive:
    """All methods on one drive; without scores, our own one alone."""
    place, drive, sensors = drive_through(scenario, split, seed, seconds)
    steps = np.diff(drive.position_m[:, :2], axis=0)
    result = Drive(seconds=drive.duration_s, moved_m=float(np.hypot(*steps.T).sum()))
    memory, false_glass = GlassMemory(), FalseGlass(config)
    grid, occupancy = config.grid, occupancy_grid(config.grid)
    for index, cloud in enumerate(clouds(place, drive, sensors)):
        result.clouds += 1
        memory, made = map_cloud(memory, cloud.xyz, cloud.intensity, cloud.odom_sensor, cloud.time_s, 0.0, config)
        if all(item.kind != "glass" for item in place.world.obstacles.items):
            false_glass.look(memory)
        if not scored:
            continue
        points = sort_points(cloud.xyz, cloud.intensity, grid, config.layers)
        occupancy = observe(occupancy, points, cloud.odom_sensor, grid, OccupancyConfig())
        if index % SCORED_EVERY == SCORED_EVERY - 1:
            maps = {name: method(cloud, config) for name, method in PEERS.items()}
            maps["occupancy grid"] = occupancy_classes(occupancy, cloud.odom_sensor, grid)
            _score(result, {OURS: made.classes, **maps}, points, place, cloud, config)
    result.false_glass = false_glass.count
    return result


def _score(
    result: Drive,
    maps: dict[str, NDArray[np.uint8]],
    points: LayerPoints,
    place: Place,
    cloud: Cloud,
    config: IntensityMapConfig,
) -> None:
    truth = truth_classes(place.outlines, cloud.world_sensor, config.grid)
    observed = observed_cells(points, config.grid)
    result.scored += 1
    found = {name: compare(classes, truth, observed) for name, classes in maps.items()}
    found[ALL_PASSED] = compare(maps[OURS], truth, passed_over(points.cell, config.grid) | observed)
    found[TWO_CELLS] = compare(maps[OURS], truth, observed, tolerance_cells=2)
    for name, counts in found.items():
        result.counts[name] = result.counts.get(name, no_counts()) + counts


def _laser_scan(cloud: Cloud, config: IntensityMapConfig) -> NDArray[np.uint8]:
    return laser_scan_map(cloud.xyz, config.grid, LaserScanConfig())


def _height_difference(cloud: Cloud, config: IntensityMapConfig) -> NDArray[np.uint8]:
    return height_difference_map(cloud.xyz, config.grid, HeightDifferenceConfig())


def _intensity_peaks(cloud: Cloud, config: IntensityMapConfig) -> NDArray[np.uint8]:
    return intensity_peak_map(cloud.xyz, cloud.intensity, config.grid, IntensityPeakConfig())


PEERS: dict[str, Callable[[Cloud, IntensityMapConfig], NDArray[np.uint8]]] = {
    "laser scan": _laser_scan,
    "height differences": _height_difference,
    "glass by intensity peaks": _intensity_peaks,
}
"""Those that know one cloud alone, by name; the occupancy grid remembers."""
