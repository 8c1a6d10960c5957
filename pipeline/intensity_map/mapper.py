"""From one cloud to the map that a planner asks: layers, classes, glass, inflation (MIM, section IV)."""

from typing import NamedTuple

from jaxtyping import Bool, Float32, Float64, UInt8

from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass import find_glass
from navtool.pipeline.intensity_map.glass_memory import GlassMemory, remember_glass, transparent_cells
from navtool.pipeline.intensity_map.inflation import inflation_kernel, planning_map
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import IntensityLayers, intensity_layers
from navtool.pipeline.intensity_map.obstacles import Obstacles, cell_classes, find_obstacles


class IntensityMap(NamedTuple):
    """What a cloud shows; all grids have r along x and c along y (docs/papers.md, eq. 1)."""

    layers: IntensityLayers
    obstacles: Obstacles
    transparent: Bool[Array, "n n"]
    """I_FN: cells of panes, those that are remembered too."""
    classes: UInt8[Array, "n n"]
    """A `CellClass` for each cell."""
    plan: Float32[Array, "n n"]
    """I_plan of eq. 11."""


def map_cloud(
    memory: GlassMemory,
    xyz: Float32[Array, "p 3"],
    intensity: Float32[Array, " p"],
    odom_sensor: Float64[Array, "3"],
    time_s: float,
    goal_rad: float,
    config: IntensityMapConfig,
) -> tuple[GlassMemory, IntensityMap]:
    """The map of a cloud, and what is remembered for the next one. The state goes in and comes out.

    Args:
        memory: Of the cloud before; ``GlassMemory()`` at first.
        xyz: Points in the frame of the sensor, in metres; those that are not finite count for nothing.
        intensity: Of each point, 0 to R; look at a recording with `judge_intensities` first.
        odom_sensor: x, y and yaw of the sensor in the odometry frame.
        time_s: Of the cloud; where it runs backwards, all glass is forgotten.
        goal_rad: Direction of the goal in the frame of the sensor.
        config: Everything else.
    """
    grid, glass = config.grid, config.glass
    points = sort_points(xyz, intensity, grid, config.layers)
    layers = intensity_layers(points, grid, config.layers)
    obstacles = find_obstacles(layers, grid, config.layers, config.obstacles)
    panes = find_glass(points, layers, obstacles.solid > 0, grid, glass)
    memory = remember_glass(memory, panes, odom_sensor, time_s, config.robot_radius_m, grid, glass)
    transparent = transparent_cells(memory, odom_sensor, grid, glass)
    plan = planning_map(obstacles, transparent, inflation_kernel(goal_rad, config.inflation))
    return memory, IntensityMap(layers, obstacles, transparent, cell_classes(obstacles, transparent), plan)
