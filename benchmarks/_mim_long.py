"""What half an hour of clouds does to the memory of the process and of the glass."""

import gc
import os
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _mim_drives import clouds, drive_through
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.mapper import map_cloud
from navtool.sim.world.scenario import Split

MINUTES, HZ, SECONDS = 30, 10, 15.0
_EVERY = 300


class LongRun(NamedTuple):
    """Memory over a long run, sampled every half minute."""

    clouds: int
    growth_mib: float
    """Growth of the process's memory: the mean of the last ten minutes over that of the second five."""
    cells: list[int]
    """That the glass memory knows, at each sample."""


def long_run(split: Split, seed: int, minutes: int, config: IntensityMapConfig) -> LongRun:
    """Drive a stretch among glass again and again, the odometry going on: an endless way past ever new panes."""
    place, drive, sensors = drive_through("mim_1", split, seed, SECONDS)
    stretch = list(clouds(place, drive, sensors))
    memory, start, begin_s = GlassMemory(), stretch[0].odom_sensor, 0.0
    offset: NDArray[np.float64] = np.zeros(3)
    resident, cells = [], []
    total = minutes * 60 * HZ
    for index in range(total):
        cloud = stretch[index % len(stretch)]
        if index and index % len(stretch) == 0:
            offset, begin_s = _after(offset, _relative(start, stretch[-1].odom_sensor)), index / HZ
        pose = _after(offset, _relative(start, cloud.odom_sensor))
        time_s = begin_s + (index % len(stretch)) / HZ
        memory, _ = map_cloud(memory, cloud.xyz, cloud.intensity, pose, time_s, 0.0, config)
        if index % _EVERY == _EVERY - 1:
            gc.collect()
            resident.append(_resident_mib())
            cells.append(int(memory.cell.size))
    third = len(resident) // 3
    growth = float(np.mean(resident[-third:]) - np.mean(resident[third // 2 : third]))
    return LongRun(total, growth, cells)


def _relative(frame: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """A pose x, y, yaw as seen from another."""
    dx, dy = pose[:2] - frame[:2]
    cosine, sine = np.cos(frame[2]), np.sin(frame[2])
    return np.array([cosine * dx + sine * dy, cosine * dy - sine * dx, pose[2] - frame[2]])


def _after(frame: NDArray[np.float64], step: NDArray[np.float64]) -> NDArray[np.float64]:
    """The pose that a step, seen from a frame, leads to."""
    cosine, sine = np.cos(frame[2]), np.sin(frame[2])
    x, y, yaw = step
    return np.array([frame[0] + cosine * x - sine * y, frame[1] + sine * x + cosine * y, frame[2] + yaw])


def _resident_mib() -> float:
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
