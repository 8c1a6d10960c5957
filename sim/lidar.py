"""Clouds of a 16-beam spinning LiDAR (Velodyne VLP-16 geometry) in a scene."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, UInt16

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

    xyz: Float32[np.ndarray, "n 3"]
    intensity: Float32[np.ndarray, "n"]
    """Calibrated reflectivity, 0-255; diffuse surfaces stay below 100."""
    ring: UInt16[np.ndarray, "n"]
    """0 is the lowest beam (-15 degrees), 15 the highest (+15 degrees)."""
    time_s: Float32[np.ndarray, "n"]
    """Relative to the end of the turn, so in (-0.1, 0]: the Velodyne driver stamps a cloud with its last packet."""


def ring_elevation_rad() -> Float[np.ndarray, "16"]:
    """Return the elevation of each ring."""
    return np.radians(np.linspace(-15.0, 15.0, RINGS))


def column_azimuth_rad() -> Float[np.ndarray, "1800"]:
    """Return the azimuth of each column in the order of firing: clockwise seen from above, from straight ahead."""
    return -np.arange(COLUMNS) * (2 * np.pi / COLUMNS)


def column_time_s() -> Float[np.ndarray, "1800"]:
    """Return the time of each column's firing relative to the end of the turn."""
    return (np.arange(COLUMNS) - (COLUMNS - 1)) * (SWEEP_S / COLUMNS)


def scan(scene: Scene, world_lidar: Float[np.ndarray, "1800 4 4"], rng: np.random.Generator) -> Scan:
    """Return the cloud of one turn; rays without a return within range are left out.

    Args:
        scene: What the beams meet.
        world_lidar: Pose of the sensor in the world at each column's firing: a moving robot distorts its cloud.
        rng: Source of range noise and of the leaves that beams meet.
    """
    sensor_rays = _sensor_rays()
    rotation = world_lidar[:, :3, :3].astype(np.float32)
    rays = np.ascontiguousarray(np.einsum("cij,jrc->irc", rotation, sensor_rays))
    origin = world_lidar[:, :3, 3].T.astype(np.float32)[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        reach, strength = _ground_returns(scene, origin, rays, rng)
        for thing in scene.things:
            columns = _columns_towards(thing, world_lidar[COLUMNS // 2])
            if columns.size:
                _thing_returns(thing, columns, origin, rays, reach, strength, rng)
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


def _sensor_rays() -> Float32[np.ndarray, "3 16 1800"]:
    elevation, azimuth = ring_elevation_rad()[:, None], column_azimuth_rad()[None, :]
    flat = np.cos(elevation)
    rays = np.broadcast_arrays(flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation))
    return np.stack(rays).astype(np.float32)


def _ground_returns(
    scene: Scene,
    origin: Float32[np.ndarray, "3 1 1800"],
    rays: Float32[np.ndarray, "3 16 1800"],
    rng: np.random.Generator,
) -> tuple[Float32[np.ndarray, "16 1800"], Float32[np.ndarray, "16 1800"]]:
    """Return range and intensity of the ground, infinite and 0 where a beam does not meet it within range."""
    reach = np.where(rays[2] < 0, -origin[2] / rays[2], np.float32(np.inf))
    met = reach < MAX_RANGE_M
    x, y = (origin[axis] + np.where(met, reach, 0) * rays[axis] for axis in (0, 1))
    terrain = scene.ground.terrain_at(x, y)
    relief = RELIEF_M[terrain] * rng.standard_normal(reach.shape, dtype=np.float32)
    reach += np.where(met, relief / np.maximum(-rays[2], np.float32(0.05)), 0)
    grazing = np.sqrt(np.maximum(-rays[2], 0))  # rough ground is brighter than Lambert's law at grazing incidence
    return reach, np.where(met, 100 * REFLECTIVITY[terrain] * grazing, np.float32(0))


def _columns_towards(thing: Thing, world_lidar: Float[np.ndarray, "4 4"]) -> np.ndarray:
    """Return the columns that may meet a thing, with a margin for what the robot moves within a turn."""
    half_x, half_y, _ = thing.shape.half_extent
    bearing = world_lidar[:3, :3].T @ (np.array(thing.shape.centre) - world_lidar[:3, 3])
    distance, reach = float(np.hypot(bearing[0], bearing[1])), float(np.hypot(half_x, half_y)) + 0.1
    if distance - reach > MAX_RANGE_M:
        return np.arange(0)
    if distance <= 1.05 * reach:
        return np.arange(COLUMNS)
    half_angle = np.arcsin(reach / distance) + 0.12
    middle = -np.arctan2(bearing[1], bearing[0])
    first, last = ((middle + side * half_angle) * (COLUMNS / (2 * np.pi)) for side in (-1, 1))
    return np.arange(int(np.floor(first)), int(np.ceil(last)) + 1)[:COLUMNS] % COLUMNS


def _thing_returns(
    thing: Thing,
    columns: np.ndarray,
    origin: Float32[np.ndarray, "3 1 1800"],
    rays: Float32[np.ndarray, "3 16 1800"],
    reach: Float32[np.ndarray, "16 1800"],
    strength: Float32[np.ndarray, "16 1800"],
    rng: np.random.Generator,
) -> None:
    """Enter a thing's returns where they are nearer than those so far."""
    from_, towards = origin[:, :, columns], rays[:, :, columns]
    enter, leave = thing.shape.span(from_, towards)
    enter = np.maximum(enter, np.float32(0))
    if not thing.material.solid:  # the free path of a beam between leaves is exponential
        enter += rng.standard_exponential(enter.shape, dtype=np.float32) / np.float32(thing.material.scatter_per_m)
    ring, index = np.nonzero((enter < leave) & (enter < reach[:, columns]))
    if not ring.size:
        return
    column, near, ray = columns[index], enter[ring, index], towards[:, ring, index]
    if thing.material.solid:
        normals = thing.shape.normal(from_[:, 0, index] + near * ray)
        facing = np.abs((normals * ray).sum(axis=0))
    else:
        facing = rng.random(near.shape, dtype=np.float32)  # leaves hang at any angle
    reach[ring, column] = near
    strength[ring, column] = np.float32(100 * thing.material.reflectivity) * (
        np.float32(0.2) + np.float32(0.8) * facing
    )
