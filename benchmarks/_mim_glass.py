"""How far from a pane a robot that drives at it learns of it, and how often there is glass where there is none."""

from typing import NamedTuple

import cv2
import numpy as np
from _mim_drives import clouds
from _mim_scenes import pane, room_with
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.mapper import map_cloud
from navtool.sim.drive.config import DriveConfig, DriverKind, PoseConfig
from navtool.sim.drive.make import roll_out
from navtool.sim.drive.script import Order
from navtool.sim.wheeled.robot import WheeledRobot

SPEED_MPS, ROBOT_M, FOUND_M = 0.5, 0.5, 1.5
STARTS_M, AT_PANE_M, MOST_RAD = (4.0, 5.0), 0.9, np.radians(15.0)
"""Where the robot begins before the pane along its way, where the drive ends, and the angle to the pane's normal."""
LENGTH_M, WIDTH_M = 14.0, 9.0
AT_PANE_WITHIN_M = 0.4
"""Cells farther than this from the pane, along the way, are not the pane's."""
_APART_CELLS = 5


class Approach(NamedTuple):
    """One drive at a pane."""

    half_m: float
    """Half the pane's length."""
    angle_rad: float
    """Between the robot's way and the pane's normal."""
    found_m: float
    """How far the sensor was from the pane along its way when a cell in its way became transparent; 0 for never."""


def approach(seed: list[int], angles_rad: tuple[float, float], config: IntensityMapConfig) -> Approach:
    """Drive straight at a pane in a room, from anywhere, at an angle within limits to either side of its normal.

    The robot's whole width meets the pane. It starts 4 to 5 m away, so that it is the drive that shows the pane.
    """
    rng = np.random.default_rng([*seed, 51])
    half = float(rng.uniform(0.5, 2.0))
    angle = float(rng.uniform(*angles_rad) * rng.choice([-1, 1]))
    offset = float(rng.uniform(-1, 1)) * (half - ROBOT_M / 2)
    start = float(rng.uniform(*STARTS_M))
    # the robot's way is the x axis, and meets the pane at the place x, 0
    x, heading = 0.5 + float(rng.uniform(-1, 1)), float(rng.uniform(-0.3, 0.3))
    way = np.array([np.cos(heading), np.sin(heading)])
    along = heading + angle + np.pi / 2
    middle = np.array([x, 0.0]) - offset * np.array([np.cos(along), np.sin(along)])
    place = room_with(LENGTH_M, WIDTH_M, seed[1], [pane(float(middle[0]), float(middle[1]), along, half)], [])
    begin = np.array([x, 0.0]) - start * way
    drive = DriveConfig(
        driver=DriverKind.script,
        duration_s=20.0,
        orders=[Order(duration_s=(start - AT_PANE_M) / SPEED_MPS, speed_mps=SPEED_MPS)],
        start=PoseConfig(x_m=float(begin[0]), y_m=float(begin[1]), yaw_rad=heading),
    )
    driven = roll_out(WheeledRobot(place.world), place.world, drive, seed[1])
    memory = GlassMemory()
    for cloud in clouds(place, driven, seed[1]):
        memory, made = map_cloud(memory, cloud.xyz, cloud.intensity, cloud.odom_sensor, cloud.time_s, 0.0, config)
        away = float((np.array([x, 0.0]) - cloud.world_sensor[:2]) @ way)
        if in_way(made.transparent, away, config).any():
            return Approach(half, angle, away)
    return Approach(half, angle, 0.0)


def in_way(transparent: NDArray[np.bool_], away_m: float, config: IntensityMapConfig) -> NDArray[np.bool_]:
    """The transparent cells straight ahead, within half the robot's width of its way, where the pane truly is."""
    n, cell = config.grid.cells, config.grid.cell_m
    axis = (np.arange(n) + 0.5 - n / 2) * cell
    at_pane = np.abs(axis - away_m) <= AT_PANE_WITHIN_M
    way: NDArray[np.bool_] = at_pane[:, None] & (np.abs(axis)[None, :] <= ROBOT_M / 2)
    return np.asarray(transparent & way)


class FalseGlass:
    """Counts panes that are claimed where there is no glass: patches of cells, apart from all that came before."""

    def __init__(self, config: IntensityMapConfig) -> None:
        self._least = config.glass.clouds
        self._known: set[tuple[int, int]] = set()
        self.count = 0

    def look(self, memory: GlassMemory) -> None:
        """Count what is new in a memory; cells within half a metre belong to one pane."""
        believed = memory.cell[memory.clouds >= self._least]
        cells = np.stack([believed >> 31, believed & ((1 << 31) - 1)], axis=1)
        new = [tuple(cell) for cell in cells.tolist() if tuple(cell) not in self._known]
        if not new:
            return
        places = np.array(new)
        low = places.min(axis=0) - _APART_CELLS
        mask = np.zeros(tuple(places.max(axis=0) - low + _APART_CELLS + 1), np.uint8)
        mask[tuple((places - low).T)] = 1
        reach = 2 * _APART_CELLS + 1
        number, labels = cv2.connectedComponents(cv2.dilate(mask, np.ones((reach, reach), np.uint8)), connectivity=8)
        for label in range(1, number):
            around = np.argwhere(labels == label) + low
            self.count += not any(tuple(cell) in self._known for cell in around.tolist())
        self._known.update((int(x), int(y)) for x, y in new)
