"""Where the simulator's benchmarks look from."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy
from navtool.sim.record.recorder_config import CameraSetup
from navtool.sim.record.rig import CAMERA, LIDAR, RIGS, RobotKind
from navtool.sim.world.place import World
from navtool.sim.world.scenario import ScenarioConfig, load_scenario

ROOT = Path(__file__).resolve().parents[1]
PLACES = 6
RIG = RIGS[RobotKind.wheeled]
BASE_HEIGHT_M = -RIG.mount("base_footprint")[2, 3]
MODEL = CameraSetup().model()


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
    """Poses of the LiDAR on a robot that stands there."""
    return np.tile(_base(stand, np.zeros(1)) @ RIG.mount(LIDAR), (columns, 1, 1))


def camera_poses(stand: Stand, time_s: NDArray[np.float64], turn_radps: float = 0.5) -> NDArray[np.float64]:
    """Poses of the camera on a robot that passes there at 0.8 m/s while it turns."""
    return np.asarray(_base(stand, time_s, turn_radps) @ RIG.mount(CAMERA))


def _base(stand: Stand, time_s: NDArray[np.float64], turn_radps: float = 0.0) -> NDArray[np.float64]:
    zero = np.zeros_like(time_s)
    xyz = np.stack([stand.x_m + 0.8 * time_s, zero + stand.y_m, zero + stand.ground_m + BASE_HEIGHT_M], axis=-1)
    return transform_from_xyz_rpy(xyz, np.stack([zero, zero, turn_radps * time_s], axis=-1))
