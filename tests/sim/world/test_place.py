from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from navtool.configs.schema import config_folder
from navtool.sim.errors import SimError
from navtool.sim.world.kinds import KINDS
from navtool.sim.world.place import FREE_M, World, make_world
from navtool.sim.world.scenario import RoomConfig, Scatter, ScenarioConfig, Split, load_scenario
from navtool.sim.world.surfaces import SURFACES, surface_number

FILES = sorted((config_folder() / "scenario").glob("*.yaml"))


@pytest.fixture(scope="module")
def world(small_scenario: ScenarioConfig) -> World:
    return make_world(small_scenario, 1)


def triangles(world: World, surface: str) -> int:
    return int((world.mesh.surface == surface_number(surface)).sum())


def test_equal_seeds_give_equal_worlds_bit_by_bit(small_scenario: ScenarioConfig, world: World) -> None:
    again = make_world(small_scenario, 1)
    for ours, theirs in zip(world.mesh, again.mesh, strict=True):
        assert ours.tobytes() == theirs.tobytes()
    assert world.ground.heights_m.tobytes() == again.ground.heights_m.tobytes()
    assert world.ground.surface.tobytes() == again.ground.surface.tobytes()
    assert world.obstacles.items == again.obstacles.items
    assert (world.start_m, world.goal_m, world.sun) == (again.start_m, again.goal_m, again.sun)


def test_seeds_names_and_splits_number_different_places(small_scenario: ScenarioConfig, world: World) -> None:
    others = [
        make_world(small_scenario, 2),
        make_world(replace(small_scenario, name="other"), 1),
        make_world(replace(small_scenario, split=Split.train), 1),
    ]
    spots = {tuple((item.x_m, item.y_m) for item in place.obstacles.items) for place in [world, *others]}
    assert len(spots) == 4


def test_one_kind_does_not_disturb_the_ground(small_scenario: ScenarioConfig, world: World) -> None:
    fewer = make_world(replace(small_scenario, bushes=Scatter(count=0)), 1)
    assert (fewer.ground.heights_m == world.ground.heights_m).all()
    assert (fewer.ground.surface == world.ground.surface).all()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_scenario_builds_with_what_it_asks_for(path: Path) -> None:
    config = load_scenario(path)
    world = make_world(config, 0)
    for name in KINDS:
        wanted = getattr(config, name).count
        there, missing = world.placed.get(name, 0), world.left_out.get(name, 0)
        assert there + missing == wanted, name
        assert missing <= 0.2 * wanted, name
    assert np.isfinite(world.mesh.vertices).all()
    assert np.isfinite(world.ground.heights_m).all()
    assert world.mesh.triangles.min() >= 0
    assert world.mesh.triangles.max() < len(world.mesh.vertices)
    assert world.mesh.surface.max() < len(SURFACES)
    assert np.linalg.norm(world.sun) == pytest.approx(1.0)
    for end in (world.start_m, world.goal_m):
        x, y = np.array([end[0]]), np.array([end[1]])
        assert world.obstacles.clearance(x, y)[0] > (FREE_M if config.room is None else 0.5)
    for region in config.regions:
        assert (world.ground.surface == surface_number(region.surface)).any(), region.surface


@pytest.mark.slow
@pytest.mark.parametrize("split", list(Split), ids=lambda split: split.name)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_scenario_has_free_ends_for_several_seeds_of_both_splits(path: Path, split: Split) -> None:
    config = replace(load_scenario(path), split=split)
    ends = set()
    for seed in (1, 2):
        world = make_world(config, seed)
        for x, y in (world.start_m, world.goal_m):
            clearance = world.obstacles.clearance(np.array([x]), np.array([y]))[0]
            assert clearance > (FREE_M if config.room is None else 0.5), (seed, x, y)
            slope = world.ground.normal_at(np.array([x]), np.array([y]))[0, 2]
            assert slope > 0.7, (seed, x, y)
        ends.add((world.start_m, world.goal_m))
    assert len(ends) == 2, "each seed is a place of its own"


def test_grass_is_made_of_thousands_of_single_blades(world: World) -> None:
    blades = triangles(world, "tall_grass") / 3
    assert blades > 1000
    thin = world.mesh.areas()[world.mesh.surface == surface_number("tall_grass")]
    assert thin.max() < 0.005


def test_leaves_hang_down_to_the_sensors_only_where_they_should(small_scenario: ScenarioConfig) -> None:
    def lowest_leaf(config: ScenarioConfig) -> float:
        world = make_world(config, 3)
        leaf = world.mesh.triangles[world.mesh.surface == surface_number("leaf")]
        corners = world.mesh.vertices[leaf].reshape(-1, 3).astype(np.float64)
        above = corners[:, 2] - world.ground.height_at(corners[:, 0], corners[:, 1])
        return float(np.quantile(above, 0.01))

    plain = replace(small_scenario, hanging_trees=Scatter())
    hanging = replace(small_scenario, trees=Scatter())
    assert lowest_leaf(hanging) < 1.0 < lowest_leaf(plain)


def test_what_stands_there_stands_on_the_ground(world: World) -> None:
    for surface in ("bark", "rock", "brick", "concrete", "tall_grass"):
        corners = world.mesh.vertices[world.mesh.triangles[world.mesh.surface == surface_number(surface)]]
        if not len(corners):
            continue
        points = corners.reshape(-1, 3).astype(np.float64)
        above = points[:, 2] - world.ground.height_at(points[:, 0], points[:, 1])
        assert above.min() < 0.1, surface


def test_vegetation_drags_and_open_ground_does_not(world: World) -> None:
    drag = world.ground.drag_at
    for item in world.obstacles.items:
        found = float(drag(np.array([item.x_m]), np.array([item.y_m]))[0])
        assert found >= np.float32(SURFACES[item.surface].drag_per_m)
    x, y = np.array([world.start_m[0]]), np.array([world.start_m[1]])
    assert drag(x, y)[0] < 0.1


def test_rooms_are_closed_and_flat() -> None:
    world = make_world(load_scenario(config_folder() / "scenario" / "mim_2.yaml"), 0)
    assert not world.ground.heights_m.any()
    assert {item.kind for item in world.obstacles.items} >= {"wall", "glass", "curtain"}
    y = np.linspace(-3.4, 3.4, 400)
    blocked = world.obstacles.only(pliable=False).clearance(np.zeros(400), y) < 0
    free = float((~blocked).mean() * 6.8)
    assert free == pytest.approx(1.1, abs=0.1), "one doorway"


def test_impossible_places_are_refused(small_scenario: ScenarioConfig) -> None:
    with pytest.raises(SimError, match="seed is -1"):
        make_world(small_scenario, -1)
    crowded = ScenarioConfig(
        side_m=20.0,
        course_m=8.0,
        room=RoomConfig(length_m=10.0, width_m=3.0),
        walls=Scatter(count=8, from_m=-2.0, to_m=2.0, gap_m=-1.0, size=[1.0, 1.0]),
    )
    with pytest.raises(SimError, match="no way from start to goal"):
        make_world(crowded, 0)


def test_what_found_no_room_is_counted(small_scenario: ScenarioConfig, caplog: pytest.LogCaptureFixture) -> None:
    world = make_world(replace(small_scenario, trees=Scatter(count=20, gap_m=6.0)), 0)
    assert world.left_out["trees"] == 20 - world.placed["trees"] > 0
    assert "no room" in caplog.text
