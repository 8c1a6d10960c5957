import numpy as np
import pytest

from navtool.sim.errors import SimError
from navtool.sim.scene import REACH_M, make_scene


def test_a_place_depends_on_seed_and_name_alone() -> None:
    first, again = make_scene(1, "here"), make_scene(1, "here")
    assert first.things == again.things
    assert (first.ground.colour == again.ground.colour).all()
    assert (first.treeline_rad == again.treeline_rad).all()
    for other in (make_scene(2, "here"), make_scene(1, "there")):
        assert other.things != first.things
        assert (other.ground.terrain != first.ground.terrain).any()


@pytest.mark.parametrize("seed", range(4))
def test_a_place_has_room_to_drive_and_something_to_run_into(seed: int) -> None:
    scene = make_scene(seed, "room")
    obstacles = scene.obstacles()
    assert sum(thing.material.solid for thing in obstacles) > 10
    assert sum(not thing.material.solid for thing in obstacles) > 10
    for index, thing in enumerate(obstacles):
        centre = np.array(thing.shape.centre[:2])
        assert (np.abs(centre) <= REACH_M).all()
        for other in obstacles[index + 1 :]:
            assert other.shape.clearance(centre[:, None])[0] > 0.8, "a robot fits between any two"
    assert len(set(scene.ground.terrain_at(*np.random.default_rng(0).uniform(-30, 30, (2, 500))).tolist())) == 3


def test_shadows_fall_away_from_the_sun() -> None:
    scene = make_scene(1, "shadow")
    wall = next(thing.shape for thing in scene.things if not hasattr(thing.shape, "radius"))
    x, y, z = wall.centre
    length = 0.6 * z / scene.sun[2]
    brightness = []
    for side in (-1, 1):
        point = np.array([x, y]) + side * length * np.array(scene.sun[:2])
        column, row = ((point + 40.0) / 0.05).astype(int)
        brightness.append(scene.ground.colour[row - 3 : row + 4, column - 3 : column + 4, :3].mean())
    assert brightness[0] < 0.75 * brightness[1]


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(SimError, match="the seed is -1"):
        make_scene(-1, "here")
