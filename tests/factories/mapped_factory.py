"""Maps of made-up points, for what draws and writes them."""

import numpy as np
from numpy.typing import NDArray

from navtool.methods.along.sweeps import Sweep, SweepDrops
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.pipeline.intensity_map.config import GridConfig, IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.mapper import map_cloud

STAMP_NS = 1_700_000_000_123_456_789


def map_config(cells: int = 20, cell_m: float = 0.5) -> IntensityMapConfig:
    """A small grid."""
    return IntensityMapConfig(grid=GridConfig(cells=cells, cell_m=cell_m))


def mapped_points(
    xyz: NDArray[np.float32],
    intensity: NDArray[np.float32],
    *,
    number: int = 0,
    config: IntensityMapConfig | None = None,
    place: tuple[float, float, float] | None = (1.0, -2.0, 0.5),
    goal_rad: float = 0.4,
) -> MappedSweep:
    """The map of some points."""
    config = config or map_config()
    odom_sensor = None if place is None else np.array(place)
    at = np.zeros(3) if odom_sensor is None else odom_sensor
    _, made = map_cloud(GlassMemory(), xyz, intensity, at, 1.0, goal_rad, config)
    sweep = Sweep(STAMP_NS + number * 100_000_000, xyz, intensity, odom_sensor, SweepDrops())
    return MappedSweep(number, sweep, made, goal_rad, config)


def mapped_anything(number: int = 0, **options: object) -> MappedSweep:
    """A map of 3000 points all over the grid, of every intensity."""
    rng = np.random.default_rng(number)
    xyz = rng.uniform((-5, -5, -0.5), (5, 5, 0.5), (3000, 3)).astype(np.float32)
    intensity = rng.uniform(0, 255, 3000).astype(np.float32)
    return mapped_points(xyz, intensity, number=number, **options)  # type: ignore[arg-type]
