"""Panes are found where beams meet them at right angles, and nowhere else."""

import numpy as np
import pytest
from intensity_scene import SceneCloud, Stand, scan_scene
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import FlatLayers, GlassConfig, GridConfig, LayerConfig, ObstacleConfig
from navtool.pipeline.intensity_map.glass import find_glass
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import intensity_layers
from navtool.pipeline.intensity_map.obstacles import find_obstacles

GRID, LAYERS, GLASS = GridConfig(), LayerConfig(), GlassConfig()


def panes(scene: SceneCloud, glass: GlassConfig = GLASS, layers: LayerConfig = LAYERS) -> NDArray[np.float32]:
    points = sort_points(scene.xyz, scene.intensity, GRID, layers)
    found = intensity_layers(points, GRID, layers)
    solid = find_obstacles(found, GRID, layers, ObstacleConfig()).solid > 0
    return find_glass(points, found, solid, GRID, glass)


def turned(cloud: SceneCloud, angle_rad: float) -> SceneCloud:
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    return SceneCloud((cloud.xyz @ turn.T).astype(np.float32), cloud.intensity)


@pytest.mark.parametrize("distance_m", [2.0, 5.0])
@pytest.mark.parametrize("angle_rad", [0.0, 1.0, 2.5, 4.0])
def test_a_pane_seen_head_on_is_found_and_extended(distance_m: float, angle_rad: float) -> None:
    pane = Stand("glass", (distance_m, -3), (distance_m, 3))
    scene = turned(scan_scene([pane]), angle_rad)
    found = panes(scene)
    assert len(found) == 1
    back = np.array([[np.cos(angle_rad), np.sin(angle_rad)], [-np.sin(angle_rad), np.cos(angle_rad)]])
    ends = found.reshape(2, 2) @ back.T
    np.testing.assert_allclose(ends[:, 0], distance_m, atol=0.12)
    assert abs(ends[:, 1].mean()) < 0.15
    patch = panes(scene, GlassConfig(extend_m=0.0)).reshape(2, 2) @ back.T
    grown = np.ptp(ends[:, 1]) - np.ptp(patch[:, 1])
    assert grown == pytest.approx(2 * GLASS.extend_m, abs=0.15)
    assert np.ptp(patch[:, 1]) < 2 * distance_m * np.tan(np.radians(10))


def test_a_pane_seen_from_an_angle_is_not_found() -> None:
    for angle in np.radians([20, 40, 60]):
        way = np.array([-np.sin(angle), np.cos(angle)])
        # the foot of the perpendicular from the sensor lies beyond the pane's end
        middle = 3 * np.array([np.cos(angle), np.sin(angle)]) + 2.5 * way
        stand = Stand("glass", tuple(middle - 1.2 * way), tuple(middle + 1.2 * way))
        assert not len(panes(scan_scene([stand])))


def test_a_weak_line_that_does_not_face_the_sensor_is_no_pane() -> None:
    rng = np.random.default_rng(0)
    for angle, expected in ((0.0, 1), (30.0, 0), (60.0, 0), (90.0, 0)):
        along = np.linspace(-0.3, 0.3, 60)
        place = np.stack([3 - along * np.sin(np.radians(angle)), along * np.cos(np.radians(angle))], axis=1)
        line = np.column_stack([place + rng.normal(0, 0.01, place.shape), np.full(60, 0.02)])
        xyz = np.concatenate([line, [[3.0, 0.0, -0.75]]]).astype(np.float32)
        assert len(panes(SceneCloud(xyz, np.full(61, 20, np.float32)))) == expected


@pytest.mark.parametrize("angle_rad", [-2.8, -1.5, 0.0, 0.4, 1.6, 3.1])
def test_a_patch_ends_where_its_outermost_points_lie_along_the_main_axis_of_all(angle_rad: float) -> None:
    rng = np.random.default_rng(4)
    line = np.column_stack([3 + rng.normal(0, 0.01, 80), rng.uniform(-0.35, 0.3, 80), np.full(80, 0.02)])
    scene = turned(SceneCloud(line.astype(np.float32), np.full(80, 20, np.float32)), angle_rad)
    ends = panes(scene, GlassConfig(extend_m=0.0)).reshape(2, 2)
    place = scene.xyz[:, :2].astype(np.float64)
    along = np.linalg.eigh(np.cov(place.T)).eigenvectors[:, 1]
    reach = (place - place.mean(axis=0)) @ along
    expected = place.mean(axis=0) + np.outer([reach.min(), reach.max()], along)
    if np.dot(ends[1] - ends[0], along) < 0:
        expected = expected[::-1]
    np.testing.assert_allclose(ends, expected, atol=2e-6)


@pytest.mark.parametrize("what", ["grass", "beads", "wall"])
@pytest.mark.parametrize("distance_m", [1.5, 3.0, 6.0])
def test_grass_curtains_and_walls_are_no_panes(what: str, distance_m: float) -> None:
    for seed in range(5):
        scene = scan_scene([Stand(what, (distance_m, -2), (distance_m, 2), 2.0)], seed)
        assert not len(panes(scene))


def test_weak_scatter_and_weak_clumps_are_no_panes() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        scatter = np.column_stack([rng.uniform(1, 6, (400, 2)), rng.uniform(-0.02, 0.02, 400)])
        clump = np.column_stack([3 + rng.normal(0, 0.02, (20, 2)), np.zeros(20)])
        for xyz in (scatter, clump):
            assert not len(panes(SceneCloud(xyz.astype(np.float32), np.full(len(xyz), 20, np.float32))))


def test_a_weak_line_among_stronger_points_is_a_curtain() -> None:
    pane = scan_scene([Stand("glass", (3, -3), (3, 3))])
    assert len(panes(pane)) == 1
    for strength, expected in ((255 * 0.25, 1), (255 * 0.45, 0)):
        beside = np.column_stack([np.full(30, 3.05), np.linspace(-0.25, 0.25, 30), np.full(30, 0.02)])
        xyz = np.concatenate([pane.xyz, beside.astype(np.float32)])
        mixed = SceneCloud(xyz, np.concatenate([pane.intensity, np.full(30, strength, np.float32)]))
        assert len(panes(mixed)) == expected


def test_the_level_layer_has_to_be_the_stronger_one() -> None:
    """Eq. 6 takes z = -epsilon away from z = 0: a weak thing that is as strong below is none."""
    scene = scan_scene([Stand("glass", (3, -2), (3, 2))])
    found = panes(scene)
    below = scene.xyz[np.abs(scene.xyz[:, 0] - 3) < 0.1]
    below = below[np.abs(below[:, 2]) < 0.1].copy()
    below[:, 2] = -3 * np.tan(np.radians(3))
    more = SceneCloud(
        np.concatenate([scene.xyz, below]), np.concatenate([scene.intensity, np.full(len(below), 200, np.float32)])
    )
    assert len(found) == 1
    assert not len(panes(more))


def test_a_pane_is_extended_up_to_a_solid_frame() -> None:
    frames = [Stand("wall", (3, side * 0.75), (3, side * 1.2)) for side in (-1, 1)]
    found = panes(scan_scene([*frames, Stand("glass", (3, -0.75), (3, 0.75))]), GlassConfig(extend_m=3.0))
    assert len(found) == 1
    assert np.abs(found.reshape(2, 2)[:, 1]).max() < 0.85


def test_thin_metric_slabs_have_no_points_of_a_pane_further_off() -> None:
    layers = LayerConfig(flat=FlatLayers.metric)
    assert len(panes(scan_scene([Stand("glass", (1, -3), (1, 3))]), layers=layers)) == 1
    assert not len(panes(scan_scene([Stand("glass", (3, -3), (3, 3))]), layers=layers))


def test_a_cloud_without_points_shows_no_pane() -> None:
    nothing = SceneCloud(np.zeros((0, 3), np.float32), np.zeros(0, np.float32))
    assert panes(nothing).shape == (0, 4)
