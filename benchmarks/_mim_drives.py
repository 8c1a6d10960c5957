"""Clouds of simulated drives as an intensity map receives them, without recording them first."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navtool.pipeline.geometry.deskew import deskewed
from navtool.pipeline.geometry.transforms import invert_transform, rpy_from_transform, transform_from_xyz_rpy
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.truth import Outline
from navtool.sim.drive.config import DriveConfig
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.make import roll_out
from navtool.sim.record.config import SimulationConfig
from navtool.sim.record.episode import make_vehicle, plan_episode
from navtool.sim.record.rig import LIDAR, RIGS, RobotKind
from navtool.sim.record.truth import obstacle_class, outline
from navtool.sim.sensors.lidar import Lidar
from navtool.sim.sensors.lidar_config import LidarConfig, Returns
from navtool.sim.world.place import World, make_world
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import Split, load_scenario

SCENARIOS = Path(__file__).resolve().parents[1] / "configs" / "scenario"
BASE_SENSOR = RIGS[RobotKind.wheeled].mount(LIDAR)
LIDAR_MODE = LidarConfig(returns=Returns.dual)
"""As the paper's VLP-16 was set (V-A): what lies behind a pane is brighter, and the strongest echo alone hides it."""
_KNOTS = 17
"""Poses of the odometry during a turn: as ingest takes the motion out of a cloud."""


class Cloud(NamedTuple):
    """One cloud, without the robot's own motion during its turn."""

    time_s: float
    xyz: NDArray[np.float32]
    """In the frame of the sensor at the cloud's stamp."""
    intensity: NDArray[np.float32]
    odom_sensor: NDArray[np.float64]
    """x, y and yaw of the sensor by the robot's own odometry."""
    world_sensor: NDArray[np.float64]
    """Where it truly is."""


@dataclass(frozen=True)
class Place:
    """A place, and what is true of it."""

    world: World
    scene: RayScene
    outlines: list[Outline]


def place_of(world: World) -> Place:
    outlines = [Outline(CellClass[obstacle_class(item)], outline(item)) for item in world.obstacles.items]
    return Place(world, RayScene(world.mesh), outlines)


def drive_through(scenario: str, split: Split, seed: int, seconds: float) -> tuple[Place, Drive, int]:
    """The first episode that ``navtool simulate`` makes of a scenario with a seed, and the seed of its sensors."""
    config = replace(load_scenario(SCENARIOS / f"{scenario}.yaml"), split=split)
    whole = SimulationConfig(scenario=config, drive=DriveConfig(duration_s=seconds))
    plan = plan_episode(whole, seed, 0)
    world = make_world(config, plan.world_seed)
    return place_of(world), roll_out(make_vehicle(whole, world), world, whole.drive, plan.drive_seed), plan.drive_seed


def clouds(place: Place, drive: Drive, seed: int, start_s: float = 0.2) -> Iterator[Cloud]:
    """Ten a second, from a moment of the drive on."""
    lidar = Lidar(LIDAR_MODE, place.world.config.weather)
    columns = lidar.config.column_time_s()
    for index, time_s in enumerate(np.arange(start_s, drive.duration_s, 1 / lidar.config.rate_hz).tolist()):
        world_sensor = drive.pose(time_s + columns) @ BASE_SENSOR
        cloud = lidar.measure(place.scene, world_sensor, np.random.default_rng([seed, index]))
        knots = np.linspace(columns[0], 0.0, _KNOTS)
        at_knots = odometry(drive, time_s + knots) @ BASE_SENSOR
        motion = invert_transform(at_knots[-1]) @ at_knots
        yield Cloud(
            time_s=time_s,
            xyz=np.ascontiguousarray(deskewed(np.ascontiguousarray(cloud.xyz.T), cloud.time_s, knots, motion).T),
            intensity=cloud.intensity,
            odom_sensor=flat(at_knots[-1]),
            world_sensor=flat(drive.pose(np.array([time_s]))[0] @ BASE_SENSOR),
        )


def odometry(drive: Drive, time_s: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pose of base_link in the odometry frame at times, [n, 4, 4]."""
    measured = drive.odometry
    x, y = (np.interp(time_s, measured.time_s, measured.values[:, axis]) for axis in (0, 1))
    yaw = np.interp(time_s, measured.time_s, np.unwrap(measured.values[:, 2]))
    zero = np.zeros_like(x)
    return np.asarray(transform_from_xyz_rpy(np.stack([x, y, zero], axis=1), np.stack([zero, zero, yaw], axis=1)))


def flat(pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """x, y and yaw of a pose."""
    return np.array([pose[0, 3], pose[1, 3], rpy_from_transform(pose)[2]])
