"""A cloud's whole map."""

import numpy as np
import pytest
from intensity_scene import SceneCloud, Stand, scan_scene

from navtool.pipeline.intensity_map.config import IntensityMapConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory
from navtool.pipeline.intensity_map.mapper import IntensityMap, map_cloud
from navtool.pipeline.intensity_map.obstacles import CellClass

CONFIG = IntensityMapConfig()


def map_twice(scene: SceneCloud, goal_rad: float = 0.0) -> IntensityMap:
    memory = GlassMemory()
    for k in range(2):
        memory, found = map_cloud(memory, scene.xyz, scene.intensity, np.zeros(3), 0.1 * k, goal_rad, CONFIG)
    return found


def near(x: float, y: float) -> tuple[slice, slice]:
    """The cells within 0.3 m."""
    row, column = round(x / 0.1 + 100), round(y / 0.1 + 100)
    return slice(row - 3, row + 3), slice(column - 3, column + 3)


def test_a_scene_of_all_kinds_is_separated_and_lies_where_it_is() -> None:
    scene = scan_scene(
        [
            Stand("wall", (4, -1), (4, 1)),
            Stand("grass", (-1, 3), (1, 3), 1.2),
            Stand("glass", (-3, -2), (-3, 2)),
            Stand("beads", (1, -3), (-1, -3), 2.0),
        ]
    )
    found = map_twice(scene)
    assert (found.classes[near(4, 0)] == CellClass.solid).sum() >= 6
    assert (found.classes[near(-3, 0)] == CellClass.transparent).sum() >= 6
    for place in (near(0, 3.2), near(0, -3)):
        there = found.classes[place]
        assert (there == CellClass.pliable).sum() >= 3
        assert not (there >= CellClass.solid).any()
    assert not found.classes[near(0, 0)].any()
    assert not found.classes[near(6, 6)].any()
    np.testing.assert_array_equal(found.transparent, found.classes == CellClass.transparent)
    # the goal lies ahead: the wall grows towards the robot, grass does not
    assert found.plan[near(3.8, 0)].min() > 0
    assert not found.plan[near(4.6, 0)].any()
    assert not found.plan[near(0, 2.6)].any()


def test_equal_clouds_give_equal_maps_and_the_order_of_points_changes_no_class() -> None:
    scene = scan_scene([Stand("wall", (4, -1), (4, 1)), Stand("grass", (-2, 3), (2, 3), 1.2)])
    first, again = map_twice(scene), map_twice(scene)
    np.testing.assert_array_equal(first.plan, again.plan)
    order = np.random.default_rng(0).permutation(len(scene.xyz))
    other = map_twice(SceneCloud(scene.xyz[order], scene.intensity[order]))
    np.testing.assert_array_equal(first.classes, other.classes)
    np.testing.assert_allclose(first.plan, other.plan, atol=1e-4)


def test_the_cloud_is_left_as_it_is() -> None:
    scene = scan_scene([Stand("wall", (4, -1), (4, 1))])
    xyz, intensity = scene.xyz.copy(), scene.intensity.copy()
    map_twice(scene)
    np.testing.assert_array_equal(xyz, scene.xyz)
    np.testing.assert_array_equal(intensity, scene.intensity)


@pytest.mark.parametrize("broken", [np.nan, np.inf, -np.inf])
def test_points_that_are_not_finite_change_nothing(broken: float) -> None:
    scene = scan_scene([Stand("wall", (4, -1), (4, 1)), Stand("glass", (-3, -2), (-3, 2))])
    more = np.tile(np.array([[3, 1, 0]], np.float32), (4, 1))
    intensity = np.full(4, 10, np.float32)
    for k in range(3):
        more[k, k] = broken
    intensity[3] = broken
    spoilt = SceneCloud(np.concatenate([more, scene.xyz]), np.concatenate([intensity, scene.intensity]))
    np.testing.assert_array_equal(map_twice(spoilt).classes, map_twice(scene).classes)


def test_an_empty_cloud_makes_an_empty_map() -> None:
    found = map_twice(SceneCloud(np.zeros((0, 3), np.float32), np.zeros(0, np.float32)))
    assert not found.classes.any()
    assert not found.plan.any()
