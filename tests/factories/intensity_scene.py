"""Clouds of a 16-beam LiDAR among walls, panes, grass and bead curtains that stand on flat ground."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SENSOR_HEIGHT_M = 0.75
GLASS_RETURNS_RAD = np.radians(10.0)


class Stand(NamedTuple):
    """Something upright between two places, from the ground to ``height_m``."""

    what: str
    """wall, glass, grass or beads."""
    start: tuple[float, float]
    end: tuple[float, float]
    height_m: float = 2.5


class SceneCloud(NamedTuple):
    xyz: NDArray[np.float32]
    intensity: NDArray[np.float32]


def scan_scene(stands: list[Stand], seed: int = 0, columns: int = 1800) -> SceneCloud:
    """The strongest returns of one turn; the sensor is at the origin, the ground below it."""
    rng = np.random.default_rng(seed)
    azimuth, elevation = np.meshgrid(
        np.linspace(-np.pi, np.pi, columns, endpoint=False), np.radians(np.arange(-15.0, 16, 2)), indexing="ij"
    )
    azimuth, elevation = azimuth.ravel(), elevation.ravel()
    beam = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    level = np.where(elevation < 0, SENSOR_HEIGHT_M / np.tan(np.maximum(-elevation, 1e-9)), np.inf)
    strength = np.clip(rng.normal(0.35, 0.08, level.size), 0, 1)
    for stand in stands:
        distance, incidence, along = _meet(beam, stand)
        height = distance * np.tan(elevation)
        met = (distance < level) & (height < stand.height_m - SENSOR_HEIGHT_M)
        depth, returned, seen = _surface(stand.what, incidence, along, elevation, rng)
        met &= seen
        level = np.where(met, distance + depth, level)
        strength = np.where(met, returned, strength)
    level = level + rng.normal(0, 0.015, level.size)
    there = np.isfinite(level) & (level < 60)
    beam, level, elevation = beam[there], level[there], elevation[there]
    xyz = np.column_stack([beam * level[:, None], level * np.tan(elevation)])
    return SceneCloud(xyz.astype(np.float32), np.clip(np.round(255 * strength[there]), 1, 255).astype(np.float32))


def _meet(
    beam: NDArray[np.float64], stand: Stand
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Level distance, level angle from the normal, and place along the foot of a stand, for each beam."""
    start, way = np.array(stand.start), np.subtract(stand.end, stand.start)
    length = float(np.hypot(*way))
    way = way / length
    normal = np.array([-way[1], way[0]])
    toward = beam @ normal
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        distance = np.nan_to_num(float(start @ normal) / toward, nan=np.inf, posinf=np.inf, neginf=np.inf)
    distance[(distance <= 0) | (distance > 1e3)] = 1e3
    along = (beam * distance[:, None] - start) @ way
    distance[(along < 0) | (along > length) | (distance >= 1e3)] = np.inf
    return distance, np.arccos(np.clip(np.abs(toward), 0, 1)), along


def _surface(
    what: str,
    incidence: NDArray[np.float64],
    along: NDArray[np.float64],
    elevation: NDArray[np.float64],
    rng: np.random.Generator,
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """How far behind the front a beam returns, how strongly, and whether at all."""
    size = incidence.size
    every = np.ones(size, bool)
    match what:
        case "wall":
            return np.zeros(size), rng.normal(0.95, 0.03, size), every
        case "glass":
            off_normal = np.hypot(incidence, elevation) / GLASS_RETURNS_RAD
            return np.zeros(size), rng.normal(0.0, 0.005, size) + 0.16 * (1 - off_normal**2), off_normal < 1
        case "grass":
            return rng.exponential(0.3, size), rng.normal(0.4, 0.15, size), rng.random(size) < 0.9
        case "beads":
            return rng.normal(0, 0.02, size), rng.normal(0.4, 0.15, size), np.abs(along % 0.08 - 0.04) < 0.012
    raise ValueError(f"no such stand: {what}")
