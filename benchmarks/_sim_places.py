"""Where the simulator's benchmarks look from."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.sim.world.place import World
from navtool.sim.world.scenario import ScenarioConfig, load_scenario

ROOT = Path(__file__).resolve().parents[1]
PLACES = 6
OPTICAL = np.array([[0.0, 0, 1, 0], [-1, 0, 0, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
MODEL = CameraModel(320, 240, 228.5, 228.5, 159.5, 119.5, "plumb_bob", (-0.28, 0.07, 0.0005, -0.0003, 0.0))


class Stand(NamedTuple):
    """Where the sensors are in a place that they have room in."""

    x_m: float
    y_m: float
    ground_m: float


def scenario(name: str) -> ScenarioConfig:
    return load_scenario(ROOT / "configs" / "scenario" / f"{name}.yaml")


def stands(world: World) -> list[Stand]:
    """Places along the course where the robot would not touch anything that does not yield."""
    found = []
    for x, y in np.linspace(world.start_m, world.goal_m, PLACES).tolist():
        at = np.array([x]), np.array([y])
        if world.obstacles.only(pliable=False).clearance(*at)[0] > 0.5:
            found.append(Stand(x, y, float(world.ground.height_at(*at)[0])))
    return found


def lidar_poses(stand: Stand, columns: int) -> NDArray[np.float64]:
    poses = np.tile(np.eye(4), (columns, 1, 1))
    poses[:, :3, 3] = stand.x_m, stand.y_m, stand.ground_m + 0.8
    return poses


def camera_poses(stand: Stand, time_s: NDArray[np.float64], turn_radps: float = 0.5) -> NDArray[np.float64]:
    zero = np.zeros_like(time_s)
    xyz = np.stack([stand.x_m + 0.8 * time_s, zero + stand.y_m, zero + stand.ground_m + 0.6], axis=-1)
    rpy = np.stack([zero, zero + 0.08, turn_radps * time_s], axis=-1)
    return np.asarray(transform_from_xyz_rpy(xyz, rpy) @ OPTICAL)
