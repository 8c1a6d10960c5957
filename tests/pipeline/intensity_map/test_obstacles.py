"""Solid and pliable cells against loops over cells; walls, grass, curtains."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from intensity_scene import Stand, scan_scene

from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, ObstacleConfig, Reduction
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import IntensityLayers, intensity_layers
from navtool.pipeline.intensity_map.obstacles import CellClass, Obstacles, cell_classes, find_obstacles

GRID = GridConfig(cells=24, cell_m=0.5)


def random_layers(seed: int, share: float = 0.2) -> IntensityLayers:
    rng = np.random.default_rng(seed)
    shape = (4, GRID.cells, GRID.cells)
    points = np.where(rng.random(shape) < share, rng.integers(1, 6, shape), 0).astype(np.float32)
    mean = rng.random(shape)
    total = (points * mean).astype(np.float32)
    largest = np.where(points > 0, np.minimum(mean * 1.2, 1.0), 0).astype(np.float32)
    return IntensityLayers(total, points, largest)


def naive_solid(layers: IntensityLayers, reduction: Reduction, obstacle: ObstacleConfig) -> set[tuple[int, int]]:
    """Cells with points around which the reduction of some layer is above the threshold."""
    assert layers.largest is not None
    solid, k = set(), obstacle.pooling_cells
    for row in range(GRID.cells):
        for column in range(GRID.cells):
            around = (slice(max(row - k, 0), row + k + 1), slice(max(column - k, 0), column + k + 1))
            above = False
            for total, points, largest in zip(layers.total, layers.points, layers.largest, strict=True):
                intensities, number = float(total[around].sum()), float(points[around].sum())
                match reduction:
                    case Reduction.sum:
                        above |= intensities / (total[around].size * GRID.cell_m**2) > obstacle.threshold
                    case Reduction.mean:
                        above |= number > 0 and intensities / number > obstacle.threshold
                    case Reduction.max:
                        above |= float(largest[around].max()) > obstacle.threshold
            if above and layers.points[:, row, column].any():
                solid.add((row, column))
    return solid


@pytest.mark.parametrize("reduction", list(Reduction))
@pytest.mark.parametrize("pooling", [0, 1, 3])
def test_cells_equal_a_loop(reduction: Reduction, pooling: int) -> None:
    sums = {0: 3.0, 1: 1.8, 3: 1.35}
    threshold = {Reduction.sum: sums[pooling], Reduction.mean: 0.53, Reduction.max: 0.98}[reduction]
    config, obstacle = LayerConfig(reduction=reduction), ObstacleConfig(threshold=threshold, pooling_cells=pooling)
    for seed in range(3):
        layers = random_layers(seed, 0.02 if reduction is Reduction.max else 0.2)
        obstacles = find_obstacles(layers, GRID, config, obstacle)
        highest = layers.values(config, GRID).max(axis=0)
        solid = naive_solid(layers, reduction, obstacle)
        assert set(map(tuple, np.argwhere(obstacles.solid).tolist())) == solid
        assert 0 < len(solid) < obstacles.seen.sum()
        np.testing.assert_array_equal(obstacles.solid + obstacles.pliable, highest)
        assert not (obstacles.solid * obstacles.pliable).any()
        np.testing.assert_array_equal(obstacles.seen, layers.points.any(axis=0))


@pytest.mark.parametrize("layer", range(4))
def test_one_layer_above_the_threshold_makes_a_cell_solid(layer: int) -> None:
    points = np.zeros((4, GRID.cells, GRID.cells), np.float32)
    points[:, 5, 7] = 1
    total = 0.2 * points
    total[layer, 5, 7] = 0.9
    obstacles = find_obstacles(IntensityLayers(total, points, None), GRID, LayerConfig(), ObstacleConfig())
    assert obstacles.solid[5, 7] == np.float32(0.9)
    assert np.count_nonzero(obstacles.solid) == 1


@pytest.mark.parametrize("pooling", [0, 2])
@pytest.mark.parametrize("reduction", list(Reduction))
def test_the_threshold_itself_is_not_above_it(reduction: Reduction, pooling: int) -> None:
    points = np.zeros((4, GRID.cells, GRID.cells), np.float32)
    points[2, 4:14, 4:14] = 3
    total, config = np.float32(0.6) * points, LayerConfig(reduction=reduction)
    layers = IntensityLayers(total, points, np.where(points > 0, np.float32(0.6), np.float32(0)))
    threshold = float(layers.values(config, GRID).max())
    for factor, expected in ((1.0, False), (0.99, True)):
        obstacle = ObstacleConfig(threshold=factor * threshold, pooling_cells=pooling)
        assert find_obstacles(layers, GRID, config, obstacle).solid.any() == expected


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10**6), low=st.floats(0.05, 0.9), more=st.floats(0, 0.5), pooling=st.integers(0, 3))
def test_a_higher_threshold_never_adds_a_solid_cell(seed: int, low: float, more: float, pooling: int) -> None:
    layers = random_layers(seed)
    solid = [
        find_obstacles(layers, GRID, LayerConfig(), ObstacleConfig(threshold=t, pooling_cells=pooling)).solid > 0
        for t in (low, low + more)
    ]
    assert not (solid[1] & ~solid[0]).any()


def test_points_without_intensity_yield_and_cells_without_points_are_free() -> None:
    points = np.zeros((4, GRID.cells, GRID.cells), np.float32)
    points[2, 3, 4] = 5
    layers = IntensityLayers(np.zeros_like(points), points, None)
    obstacles = find_obstacles(layers, GRID, LayerConfig(), ObstacleConfig())
    classes = cell_classes(obstacles, np.zeros(points.shape[1:], bool))
    assert np.argwhere(classes).tolist() == [[3, 4]]
    assert classes[3, 4] == CellClass.pliable


def test_solid_goes_before_transparent_and_that_before_pliable() -> None:
    solid, pliable = np.array([[1, 0, 0, 0]], np.float32), np.array([[0, 0.3, 0, 0.3]], np.float32)
    square = [np.vstack([row, np.zeros((3, 4), row.dtype)]) for row in (solid, pliable)]
    transparent = np.zeros((4, 4), bool)
    transparent[0, :3] = True
    classes = cell_classes(Obstacles(square[0], square[1], square[0] + square[1] > 0), transparent)
    expected = [CellClass.solid, CellClass.transparent, CellClass.transparent, CellClass.pliable]
    assert classes[0].tolist() == expected
    assert not classes[1:].any()


@pytest.mark.parametrize(
    ("what", "expected"), [("wall", CellClass.solid), ("grass", CellClass.pliable), ("beads", CellClass.pliable)]
)
def test_walls_are_solid_and_grass_and_curtains_yield(what: str, expected: CellClass) -> None:
    scene = scan_scene([Stand(what, (3, -1.5), (3, 1.5), 1.5)])
    grid, config = GridConfig(), LayerConfig()
    layers = intensity_layers(sort_points(scene.xyz, scene.intensity, grid, config), grid, config)
    none = np.zeros((grid.cells, grid.cells), bool)
    classes = cell_classes(find_obstacles(layers, grid, config, ObstacleConfig()), none)
    there = classes[classes != CellClass.free]
    assert there.size > 25
    assert (there == expected).mean() > 0.95
