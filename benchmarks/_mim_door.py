"""Whether the inflated map leaves a robot a way through a door."""

from dataclasses import dataclass
from typing import NamedTuple

import cv2
import numpy as np
from _mim_drives import BASE_SENSOR, LIDAR_MODE
from _mim_scenes import lintel, room_with, wall
from numpy.typing import NDArray

from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.pipeline.intensity_map.config import Inflation, InflationConfig, IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.mapper import map_cloud
from navtool.sim.record.rig import RIGS, RobotKind
from navtool.sim.sensors.lidar import Lidar

DOOR_M, ROBOT_M = 0.9, 0.5
HALF_ROBOT_CELLS = 3
"""Half the robot's width, in whole cells of 0.1 m: the adaptive inflation's in every direction."""
KERNEL_CELLS = 11
"""Width of the adaptive and of the uniform inflation: they grow obstacles by 0.5 m."""
LENGTH_M, WIDTH_M = 12.0, 8.0
NEAR_M, FAR_M, MOST_RAD = 1.5, 4.0, np.radians(30.0)
BEHIND_M = 1.5
_BASE_HEIGHT_M = -RIGS[RobotKind.wheeled].mount("base_footprint")[2, 3]


@dataclass(frozen=True)
class Inflated:
    """A way of inflation, by its name."""

    name: str
    inflation: InflationConfig


WAYS = (
    Inflated("adaptive", InflationConfig(size_cells=KERNEL_CELLS, minor_cells=HALF_ROBOT_CELLS)),
    Inflated("uniform", InflationConfig(size_cells=KERNEL_CELLS, method=Inflation.uniform)),
    Inflated("uniform, half the robot's width", InflationConfig(size_cells=7, method=Inflation.uniform)),
)


class Door(NamedTuple):
    """One look at a door."""

    distance_m: float
    angle_rad: float
    """Direction of the robot as seen from the door, from the door's normal."""
    open: dict[str, bool]
    """Whether each of `WAYS` leaves a way."""


def door(seed: list[int], config: IntensityMapConfig) -> Door:
    """A robot stands before a door, at any place and heading, with its goal behind the door; one cloud is mapped."""
    rng = np.random.default_rng([*seed, 52])
    middle = float(rng.uniform(-1.5, 1.5))
    half_width = WIDTH_M / 2
    pieces = [wall(-half_width, middle - DOOR_M / 2), wall(middle + DOOR_M / 2, half_width)]
    place = room_with(LENGTH_M, WIDTH_M, seed[-1], pieces, [lintel(middle, DOOR_M / 2)])
    distance, angle = float(rng.uniform(NEAR_M, FAR_M)), float(rng.uniform(-MOST_RAD, MOST_RAD))
    x, y = -distance * np.cos(angle), middle - distance * np.sin(angle)
    yaw = float(rng.uniform(-np.pi, np.pi))
    base = transform_from_xyz_rpy(np.array([x, y, _BASE_HEIGHT_M]), np.array([0.0, 0.0, yaw]))
    sensor = base @ BASE_SENSOR
    lidar = Lidar(LIDAR_MODE)
    cloud = lidar.measure(place.scene, np.tile(sensor, (lidar.config.columns, 1, 1)), rng)
    goal = np.linalg.inv(sensor) @ np.array([BEHIND_M, middle, 0.0, 1.0])
    robot = np.linalg.inv(sensor) @ np.append(base[:3, 3], 1.0)
    goal_rad = float(np.arctan2(goal[1], goal[0]))
    here = np.zeros(3)
    found = {}
    for way in WAYS:
        inflated = IntensityMapConfig(
            grid=config.grid,
            layers=config.layers,
            obstacles=config.obstacles,
            glass=config.glass,
            inflation=way.inflation,
        )
        made = map_cloud(GlassMemory(), cloud.xyz, cloud.intensity, here, 0.0, goal_rad, inflated)[1]
        found[way.name] = has_way(made.plan, robot[:2], goal[:2], config.grid.cell_m)
    return Door(distance, angle, found)


def has_way(plan: NDArray[np.float32], start_m: NDArray[np.float64], end_m: NDArray[np.float64], cell_m: float) -> bool:
    """Whether the robot's centre comes from one place to another through cells that cost nothing, side by side.

    Cells that meet at a corner alone are no way.
    """
    _, region = cv2.connectedComponents((plan == 0).astype(np.uint8), connectivity=4)
    ends = [np.floor(place / cell_m + len(plan) / 2).astype(int) for place in (start_m, end_m)]
    first, last = (int(region[row, column]) for row, column in ends)
    return first == last != 0
