import numpy as np
import pytest

from navtool.configs.schema import config_folder
from navtool.pipeline.arrays import Array
from navtool.sim.sensors.baked_light import BakedLight
from navtool.sim.sensors.lamps import Lamps
from navtool.sim.world.place import make_world
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import RoomConfig, load_scenario

ROOM = RoomConfig(length_m=14.0, width_m=8.0, height_m=2.8)


def level(x: Array, y: Array, z: float = 0.0) -> tuple[Array, Array]:
    """Points and normals of level sheets."""
    points = np.stack([x, y, np.full_like(x, z)]).astype(np.float32)
    normals = np.zeros_like(points)
    normals[2] = 1
    return points, normals


def test_lamps_light_the_floor_with_one_on_average() -> None:
    x, y = (axis.ravel() for axis in np.meshgrid(np.linspace(-6.9, 6.9, 90), np.linspace(-3.9, 3.9, 60)))
    assert Lamps(ROOM).unshaded(*level(x, y)).mean() == pytest.approx(1.0, abs=0.05)


def test_light_falls_with_the_square_of_the_distance_and_from_below_a_lamp_to_the_corner() -> None:
    lamps = Lamps(ROOM)
    place = lamps.places_m[0]
    x, y = np.full(2, place[0]), np.full(2, place[1])
    low, high = (lamps.light_of(place, *level(x, y, z))[0] for z in (float(place[2]) - 2.0, float(place[2]) - 1.0))
    assert high == pytest.approx(4 * low, rel=1e-4)
    floor = lamps.unshaded(*level(np.array([place[0], -7.0]), np.array([place[1], -4.0])))
    assert floor[1] < 0.6 * floor[0]


def test_the_floor_lies_in_the_shadow_of_what_stands_there() -> None:
    world = make_world(load_scenario(config_folder() / "scenario" / "mim_1.yaml"), 1)
    light, room = BakedLight(world, RayScene(world.mesh)), world.config.room
    assert room is not None
    x, y = (axis.ravel().astype(np.float32) for axis in np.meshgrid(np.linspace(-6, 6, 80), np.linspace(-3, 3, 50)))
    baked, bare = light.on_ground(x, y)[2], Lamps(room).unshaded(*level(x, y))
    assert (baked <= 1.1 * bare + 0.02).all()
    near = world.obstacles.only(pliable=False).clearance(x.astype(np.float64), y.astype(np.float64))
    beside, open_floor = (near > 0.02) & (near < 0.2), near > 1.0
    assert (baked / bare)[beside].mean() < 0.9 * (baked / bare)[open_floor].mean()
