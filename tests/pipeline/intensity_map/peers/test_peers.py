"""The other maps on simple scenes: where each of them is right, and where it errs."""

from collections.abc import Callable

import numpy as np
import pytest
from intensity_scene import SceneCloud, Stand, scan_scene
from numpy.typing import NDArray

from navtool.base.setting_error import SettingError
from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig
from navtool.pipeline.intensity_map.layer_points import LayerPoints, sort_points
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.peers.height_difference import HeightDifferenceConfig, height_difference_map
from navtool.pipeline.intensity_map.peers.intensity_peaks import IntensityPeakConfig, intensity_peak_map
from navtool.pipeline.intensity_map.peers.laser_scan_map import LaserScanConfig, laser_scan_map, one_ring
from navtool.pipeline.intensity_map.peers.occupancy_grid import (
    OccupancyConfig,
    OccupancyGrid,
    observe,
    occupancy_classes,
    occupancy_grid,
)

Classes = NDArray[np.uint8]
Make = Callable[[SceneCloud], Classes]

GRID = GridConfig()
WALL = Stand("wall", (4, -1), (4, 1))
GRASS = Stand("grass", (-1, 3), (1, 3), 1.4)
GLASS = Stand("glass", (-3, -2), (-3, 2))
NOTHING = SceneCloud(np.zeros((0, 3), np.float32), np.zeros(0, np.float32))


def sorted_points(scene: SceneCloud) -> LayerPoints:
    return sort_points(scene.xyz, scene.intensity, GRID, LayerConfig())


def occupancy(scene: SceneCloud) -> Classes:
    known = observe(occupancy_grid(GRID), sorted_points(scene), np.zeros(3), GRID, OccupancyConfig())
    return occupancy_classes(known, np.zeros(3), GRID)


def scan_map(scene: SceneCloud) -> Classes:
    return laser_scan_map(scene.xyz, GRID, LaserScanConfig())


def heights(scene: SceneCloud) -> Classes:
    return height_difference_map(scene.xyz, GRID, HeightDifferenceConfig())


def peaks(scene: SceneCloud) -> Classes:
    return intensity_peak_map(scene.xyz, scene.intensity, GRID, IntensityPeakConfig())


MAPS = [occupancy, scan_map, heights, peaks]


def count(classes: Classes, what: CellClass, x: float, y: float) -> int:
    """How many cells within half a metre are of a class."""
    row, column = round(x / 0.1 + 100), round(y / 0.1 + 100)
    return int((classes[row - 5 : row + 5, column - 5 : column + 5] == what).sum())


@pytest.mark.parametrize("make", MAPS)
def test_a_wall_is_solid_and_open_ground_is_free(make: Make) -> None:
    classes = make(scan_scene([WALL]))
    assert classes.shape == (200, 200)
    assert classes.dtype == np.uint8
    assert count(classes, CellClass.solid, 4, 0) >= 8
    off = np.hypot(*(np.argwhere(classes) - (140, 100)).T)
    assert off.max() < 15, "nothing but the wall"


@pytest.mark.parametrize("make", MAPS)
def test_grass_is_taken_for_solid_by_all_of_them(make: Make) -> None:
    assert count(make(scan_scene([GRASS])), CellClass.solid, 0, 3.2) >= 4


@pytest.mark.parametrize("make", MAPS)
def test_an_empty_cloud_makes_an_empty_map(make: Make) -> None:
    assert not make(NOTHING).any()


@pytest.mark.parametrize("make", MAPS)
def test_points_that_are_not_finite_or_far_change_nothing(make: Make) -> None:
    scene = scan_scene([WALL])
    more = np.array([[np.nan, 1, 0], [1, np.inf, 0], [1, 1, np.nan], [60, 0, 1], [1, 1, -np.inf]], np.float32)
    spoilt = SceneCloud(np.concatenate([more, scene.xyz]), np.concatenate([np.full(5, 9, np.float32), scene.intensity]))
    np.testing.assert_array_equal(make(spoilt), make(scene))


@pytest.mark.parametrize("angle_rad", [0.0, 0.8, 2.0, 3.14159])
def test_a_pane_has_a_peak_where_beams_meet_it_at_right_angles(angle_rad: float) -> None:
    scene = scan_scene([GLASS])
    cosine, sine = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[cosine, sine, 0], [-sine, cosine, 0], [0, 0, 1]])
    classes = peaks(SceneCloud((scene.xyz @ turn).astype(np.float32), scene.intensity))
    assert count(classes, CellClass.transparent, -3 * cosine, -3 * sine) >= 3


@pytest.mark.parametrize("distance_m", [2.0, 4.0])
def test_walls_have_no_peak(distance_m: float) -> None:
    for seed in range(5):
        classes = peaks(scan_scene([Stand("wall", (distance_m, -2), (distance_m, 2))], seed))
        assert not (classes == CellClass.transparent).any()


def test_a_weak_wall_that_is_met_aslant_has_no_peak() -> None:
    azimuth = np.linspace(0.6, 1.0, 120)
    reach = 3 / np.cos(azimuth)
    share = 30 * np.exp(-(((azimuth - 0.8) / 0.08) ** 2))
    xyz = np.column_stack([reach * np.cos(azimuth), reach * np.sin(azimuth), reach * np.tan(np.radians(1))])
    aslant = SceneCloud(xyz.astype(np.float32), share.astype(np.float32))
    assert not (peaks(aslant) == CellClass.transparent).any()
    facing = 3 / np.cos(azimuth - 0.8)
    xyz = np.column_stack([facing * np.cos(azimuth), facing * np.sin(azimuth), facing * np.tan(np.radians(1))])
    assert (peaks(SceneCloud(xyz.astype(np.float32), share.astype(np.float32))) == CellClass.transparent).any()


def test_a_ring_has_the_nearest_return_of_each_beam_in_the_order_of_azimuth() -> None:
    scene = scan_scene([WALL, GRASS, GLASS])
    behind = SceneCloud(
        np.concatenate([1.5 * scene.xyz, scene.xyz]), np.concatenate([scene.intensity, scene.intensity])
    )
    config = LaserScanConfig(beams=360)
    ring = behind.xyz[one_ring(behind.xyz, config)]
    azimuth = np.arctan2(ring[:, 1], ring[:, 0])
    assert (np.diff(azimuth) > 0).all()
    elevation = np.arctan2(ring[:, 2], np.hypot(ring[:, 0], ring[:, 1]))
    np.testing.assert_allclose(elevation, np.radians(1), atol=1e-3)
    assert np.hypot(ring[:, 0], ring[:, 1]).max() < 6


def known_after(clouds: list[SceneCloud], poses: list[tuple[float, float, float]]) -> OccupancyGrid:
    known = occupancy_grid(GRID)
    for cloud, pose in zip(clouds, poses, strict=True):
        known = observe(known, sorted_points(cloud), np.array(pose), GRID, OccupancyConfig())
    return known


def test_beams_through_a_cell_clear_it() -> None:
    box, wall = Stand("wall", (2, -0.2), (2, 0.2)), Stand("wall", (6, -3), (6, 3))
    with_box, without = scan_scene([box, wall]), scan_scene([wall])
    origin = (0.0, 0.0, 0.0)
    before = occupancy_classes(known_after([with_box], [origin]), np.zeros(3), GRID)
    after = occupancy_classes(known_after([with_box, *[without] * 4], [origin] * 5), np.zeros(3), GRID)
    assert count(before, CellClass.solid, 2, 0) >= 4
    assert count(after, CellClass.solid, 2, 0) == 0
    assert count(after, CellClass.solid, 6, 0) >= 6


def test_log_odds_stay_within_their_bounds_and_equal_a_loop() -> None:
    scene, config = scan_scene([WALL]), OccupancyConfig()
    known = known_after([scene] * 20, [(0.0, 0.0, 0.0)] * 20)
    assert known.log_odds.max() == np.float32(config.highest)
    assert known.log_odds.min() == np.float32(config.lowest)
    once = known_after([scene], [(0.0, 0.0, 0.0)])
    assert set(np.unique(once.log_odds)) == {np.float32(config.miss), np.float32(0), np.float32(config.hit)}
    # each cell between the sensor and a hit, walked in small steps, has been passed
    corner = np.array(once.corner)
    for hit in np.argwhere(once.log_odds > 0):
        middle = hit + 0.5 + corner
        for share in np.arange(0.05, 0.95, 0.05):
            row, column = np.floor(share * middle).astype(int) - corner
            assert once.log_odds[row, column] != 0


@pytest.mark.parametrize("way", [(1.0, 0.5, 0.4), (-0.7, 0.3, -2.0), (0.0, 0.0, 3.0)])
def test_the_grid_stays_where_it_is_while_the_robot_moves(way: tuple[float, float, float]) -> None:
    known = known_after([scan_scene([WALL]), NOTHING], [(0.0, 0.0, 0.0), way])
    cells = (np.argwhere(occupancy_classes(known, np.array(way), GRID)) + 0.5 - 100) * 0.1
    cosine, sine = np.cos(way[2]), np.sin(way[2])
    in_odometry = cells @ np.array([[cosine, sine], [-sine, cosine]]) + way[:2]
    assert len(in_odometry) >= 15
    assert np.abs(in_odometry[:, 0] - 4).max() < 0.25
    assert np.abs(in_odometry[:, 1]).max() < 1.2
    gone = observe(known, sorted_points(NOTHING), np.array([100.0, 0, 0]), GRID, OccupancyConfig())
    assert not gone.log_odds.any()
    assert known.log_odds.any(), "what it was is left as it is"


def test_settings_that_make_no_map_are_refused() -> None:
    for make in (
        lambda: OccupancyConfig(hit=-1.0),
        lambda: LaserScanConfig(beams=3),
        lambda: LaserScanConfig(opening_rad=0.0),
        lambda: HeightDifferenceConfig(step_m=0.0),
        lambda: IntensityPeakConfig(drop=1.0),
        lambda: IntensityPeakConfig(smooth_beams=4),
    ):
        with pytest.raises(SettingError, match=r"outside|not above|even|not 8 or more"):
            make()
