"""Clouds of a 16-beam spinning LiDAR (Velodyne VLP-16 geometry) in a scene."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, UInt16

from navtool.pipeline.arrays import Array
from navtool.sim.ground import REFLECTIVITY, RELIEF_M
from navtool.sim.scene import Scene, Thing

RINGS = 16
COLUMNS = 1800
SWEEP_S = 0.1
MIN_RANGE_M = 0.4
MAX_RANGE_M = 100.0
RANGE_NOISE_M = 0.015
"""Standard deviation of a range on a hard surface."""
_RANGE_STEP_M = 0.002


class Scan(NamedTuple):
    """The returns of one turn, column by column, each in the sensor frame at the time of its own firing."""

    xyz: Float32[Array, "n 3"]
    intensity: Float32[Array, "n"]
    """Calibrated reflectivity, 0-255; diffuse surfaces stay below 100."""
    ring: UInt16[Array, "n"]
    """0 is the lowest beam (-15 degrees), 15 the highest (+15 degrees)."""
    time_s: Float32[Array, "n"]
    """Relative to the end of the turn, so in (-0.1, 0]: the Velodyne driver stamps a cloud with its last packet."""


def ring_elevation_rad() -> Float[Array, "16"]:
    """Return the elevation of each ring."""
    return np.linspace(-15.0, 15.0, RINGS) * (np.pi / 180)


def column_azimuth_rad() -> Float[Array, "1800"]:
    """Return the azimuth of each column in the order of firing: clockwise seen from above, from straight ahead."""
    return np.arange(COLUMNS) * (-2 * np.pi / COLUMNS)


def column_time_s() -> Float[Array, "1800"]:
    """Return the time of each column's firing relative to the end of the turn."""
    return np.arange(1 - COLUMNS, 1) * (SWEEP_S / COLUMNS)


def scan(scene: Scene, world_lidar: Float[Array, "1800 4 4"], rng: np.random.Generator) -> Scan:
    """Return the cloud of one turn; rays without a return within range are left out.

    Args:
        scene: What the beams meet.
        world_lidar: Pose of the sensor in the world at each column's firing: a moving robot distorts its cloud.
        rng: Source of range noise and of the leaves that beams meet.
    """
    sensor_rays = _sensor_rays()
    rotation = world_lidar[:, :3, :3].transpose(1, 2, 0).astype(np.float32)
    rays = np.stack([sum(rotation[row, axis] * sensor_rays[axis] for axis in range(3)) for row in range(3)])
    origin = np.ascontiguousarray(world_lidar[:, :3, 3].T.astype(np.float32))[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach, strength = _ground_returns(scene, origin, rays, rng)
        for thing, window in _in_reach(scene, world_lidar[COLUMNS // 2]):
            _thing_returns(thing, origin[:, :, window[1]], rays[:, *window], reach[window], strength[window], rng)
    noise = rng.standard_normal(reach.shape, dtype=np.float32) * np.float32(RANGE_NOISE_M)
    step = np.float32(_RANGE_STEP_M)
    found = (reach > MIN_RANGE_M) & (reach < MAX_RANGE_M)
    reach = np.round((np.where(found, reach, 0) + noise) / step) * step
    kept = found.T  # column by column, as the sensor fires
    ring, column = np.broadcast_arrays(np.arange(RINGS, dtype=np.uint16)[:, None], np.arange(COLUMNS)[None, :])
    time_s = column_time_s().astype(np.float32)
    return Scan(
        xyz=np.stack([(reach * axis).T[kept] for axis in sensor_rays], axis=-1),
        intensity=np.round(np.clip(strength, 1, 255)).T[kept],
        ring=ring.T[kept],
        time_s=time_s[column.T[kept]],
    )


def _sensor_rays() -> Float32[Array, "3 16 1800"]:
    elevation, azimuth = ring_elevation_rad()[:, None], column_azimuth_rad()[None, :]
    flat = np.cos(elevation)
    rays = np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation))
    return np.stack(rays).astype(np.float32)


def _ground_returns(
    scene: Scene,
    origin: Float32[Array, "3 1 1800"],
    rays: Float32[Array, "3 16 1800"],
    rng: np.random.Generator,
) -> tuple[Float32[Array, "16 1800"], Float32[Array, "16 1800"]]:
    """Return range and intensity of the ground, infinite and 0 where a beam does not meet it within range."""
    reach = np.where(rays[2] < 0, -origin[2] / rays[2], np.float32(np.inf))
    met = reach < MAX_RANGE_M
    x, y = (origin[axis] + np.where(met, reach, 0) * rays[axis] for axis in (0, 1))
    terrain = scene.ground.terrain_at(x, y)
    relief = RELIEF_M[terrain] * rng.standard_normal(reach.shape, dtype=np.float32)
    reach += np.where(met, relief / np.maximum(-rays[2], np.float32(0.05)), 0)
    grazing = np.sqrt(np.maximum(-rays[2], 0))  # rough ground is brighter than Lambert's law at grazing incidence
    return reach, np.where(met, 100 * REFLECTIVITY[terrain] * grazing, np.float32(0))


def _in_reach(scene: Scene, world_lidar: Float[Array, "4 4"]) -> Iterator[tuple[Thing, tuple[slice, slice]]]:
    """Yield the things within range with the rings and columns that may meet them, twice for one behind the start.

    Bounds hold from the middle of the turn, with margins for how far the robot moves and turns until its ends.
    """
    corners = (scene.corners() - world_lidar[:3, 3]) @ world_lidar[:3, :3]
    centre = corners.mean(axis=1)
    radius = np.hypot(*(corners - centre[:, None, :])[..., :2].max(axis=1).T) + 0.1
    distance = np.hypot(centre[:, 0], centre[:, 1])
    near = np.maximum(distance - radius, 0.05)
    low, high = corners[..., 2].min(axis=1) - 0.05, corners[..., 2].max(axis=1) + 0.05
    lowest = np.arctan2(low, np.where(low < 0, near, distance + radius)) - 0.03
    highest = np.arctan2(high, np.where(high < 0, distance + radius, near)) + 0.03
    elevation = ring_elevation_rad()
    first_ring, last_ring = np.searchsorted(elevation, lowest), np.searchsorted(elevation, highest)
    half_angle = np.arcsin(np.minimum(radius / np.maximum(distance, 1e-6), 1.0)) + 0.06
    half_angle[distance < 1.05 * radius] = np.pi
    middle = -np.arctan2(centre[:, 1], centre[:, 0])
    first, last = (((middle + side * half_angle) * (COLUMNS / (2 * np.pi))).astype(np.int64) for side in (-1, 1))
    for index in np.flatnonzero((near < MAX_RANGE_M) & (first_ring < last_ring)).tolist():
        rings = slice(int(first_ring[index]), int(last_ring[index]))
        start, stop = int(first[index]), min(int(last[index]) + 1, int(first[index]) + COLUMNS)
        for turn in range(-COLUMNS, 2 * COLUMNS, COLUMNS):
            columns = slice(max(start - turn, 0), min(stop - turn, COLUMNS))
            if columns.start < columns.stop:
                yield scene.things[index], (rings, columns)


def _thing_returns(
    thing: Thing,
    origin: Float32[Array, "3 1 c"],
    rays: Float32[Array, "3 r c"],
    reach: Float32[Array, "r c"],
    strength: Float32[Array, "r c"],
    rng: np.random.Generator,
) -> None:
    """Enter a thing's returns into a window of ranges and intensities, where they are nearer than those so far."""
    enter, leave = thing.shape.span(origin, rays)
    enter = np.maximum(enter, np.float32(0))
    if not thing.material.solid:  # the free path of a beam between leaves is exponential
        enter += rng.standard_exponential(enter.shape, dtype=np.float32) / np.float32(thing.material.scatter_per_m)
    met = (enter < leave) & (enter < reach)
    if not met.any():
        return
    near = np.where(met, enter, np.float32(1))
    if thing.material.solid:
        x, y, z = thing.shape.normal(origin + near * rays)
        facing = np.abs(x * rays[0] + y * rays[1] + z * rays[2])
    else:
        facing = rng.random(near.shape, dtype=np.float32)  # leaves hang at any angle
    np.copyto(reach, near, where=met)
    returned = np.float32(100 * thing.material.reflectivity) * (np.float32(0.2) + np.float32(0.8) * facing)
    np.copyto(strength, returned, where=met)
