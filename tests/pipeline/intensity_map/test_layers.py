"""Layers against a loop over points; edges, ground, degenerate clouds."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from intensity_scene import Stand, scan_scene
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import FlatLayers, GridConfig, LayerConfig, Reduction
from navtool.pipeline.intensity_map.layer_points import STEEPEST_GROUND, Layer, sort_points
from navtool.pipeline.intensity_map.layers import IntensityLayers, intensity_layers

Cloud = NDArray[np.float32]

GRID = GridConfig(cells=40, cell_m=0.25)


def layers_of(xyz: Cloud, intensity: Cloud, grid: GridConfig, config: LayerConfig) -> IntensityLayers:
    return intensity_layers(sort_points(xyz, intensity, grid, config), grid, config)


def naive_layer(x: float, y: float, z: float, config: LayerConfig) -> Layer | None:
    if not abs(z) <= config.height_m:
        return None
    if config.flat is FlatLayers.angular:
        reach = math.hypot(x, y)
        level, below = math.tan(config.flat_rad) * reach, math.tan(3 * config.flat_rad) * reach
    else:
        level, below = config.flat_m, 3 * config.flat_m
    if -level <= z <= level:
        return Layer.level
    if -below <= z < -level:
        return Layer.below
    return Layer.upper if z > 0 else Layer.lower


type Blocks = dict[tuple[int, int], float]


def naive_ground(xyz: list[list[float]], grid: GridConfig, config: LayerConfig) -> Blocks:
    """The highest of the lowest around of the lowest points of each block of 1 m: its ground, where it is known."""
    lowest: Blocks = {}
    for x, y, z in xyz:
        if math.isfinite(z) and all(-grid.half_m <= part < grid.half_m for part in (x, y)):
            block = (math.floor(x + grid.half_m), math.floor(y + grid.half_m))
            lowest[block] = min(lowest.get(block, math.inf), z)
    for row, column in list(lowest):
        away = math.hypot(row + 0.5 - grid.half_m, column + 0.5 - grid.half_m)
        if lowest[row, column] >= STEEPEST_GROUND * away - config.sensor_height_m:
            del lowest[row, column]
    around = {block: min(neighbours(lowest, block)) for block in lowest}
    blocks = range(math.ceil(2 * grid.half_m))
    opened: Blocks = {}
    for block in itertools.product(blocks, blocks):
        if neighbours(lowest, block):
            opened[block] = max(neighbours(around, block))
    return opened


def neighbours(of: Blocks, block: tuple[int, int]) -> list[float]:
    near = ((block[0] + i, block[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1))
    return [of[place] for place in near if place in of]


def naive_values(xyz: Cloud, intensity: Cloud, grid: GridConfig, config: LayerConfig) -> NDArray[np.float64]:
    found: dict[tuple[int, int, int], list[float]] = {}
    points = xyz.astype(float).tolist()
    known = naive_ground(points, grid, config)
    for (x, y, z), value in zip(points, intensity.astype(float).tolist(), strict=True):
        if not all(math.isfinite(number) for number in (x, y, z, value)):
            continue
        row, column = math.floor(x / grid.cell_m + grid.cells / 2), math.floor(y / grid.cell_m + grid.cells / 2)
        layer = naive_layer(x, y, z, config)
        if layer is None or not (0 <= row < grid.cells and 0 <= column < grid.cells):
            continue
        if config.ground_margin_m:
            block = (math.floor(x + grid.half_m), math.floor(y + grid.half_m))
            ground = known.get(block, -config.sensor_height_m)
            if not z > ground + config.ground_margin_m:
                continue
        found.setdefault((layer, row, column), []).append(min(max(value / config.full_scale, 0.0), 1.0))
    values = np.zeros((4, grid.cells, grid.cells))
    for place, shares in found.items():
        match config.reduction:
            case Reduction.sum:
                values[place] = sum(shares) / grid.cell_m**2
            case Reduction.mean:
                values[place] = sum(shares) / len(shares)
            case Reduction.max:
                values[place] = max(shares)
    return values


def random_cloud(seed: int, points: int = 3000) -> tuple[Cloud, Cloud]:
    """Points in and around the grid, some of them not finite."""
    rng = np.random.default_rng(seed)
    xyz = rng.uniform([-6, -6, -1], [6, 6, 1], (points, 3))
    xyz[::2, 2] *= 0.1
    xyz[rng.integers(0, points, 60), rng.integers(0, 3, 60)] = rng.choice([np.nan, np.inf, -np.inf], 60)
    intensity = rng.uniform(-20, 300, points)
    intensity[rng.integers(0, points, 30)] = rng.choice([np.nan, np.inf, -np.inf], 30)
    return xyz.astype(np.float32), intensity.astype(np.float32)


@pytest.mark.parametrize("reduction", list(Reduction))
@pytest.mark.parametrize("flat", list(FlatLayers))
@pytest.mark.parametrize("ground_margin_m", [0.0, 0.25])
def test_layers_equal_a_loop_over_points(reduction: Reduction, flat: FlatLayers, ground_margin_m: float) -> None:
    config = LayerConfig(reduction=reduction, flat=flat, flat_m=0.05, ground_margin_m=ground_margin_m)
    for seed in range(3):
        xyz, intensity = random_cloud(seed)
        values = layers_of(xyz, intensity, GRID, config).values(config, GRID)
        assert (values > 0).any(axis=(1, 2)).all(), "each layer has points"
        np.testing.assert_allclose(values, naive_values(xyz, intensity, GRID, config), atol=2e-4, rtol=1e-5)


@pytest.mark.parametrize("points", [20, 100, 300])
def test_sparse_clouds_equal_a_loop_over_points(points: int) -> None:
    """Most blocks have no point that may be ground, and many no neighbour with one."""
    for seed in range(20):
        xyz, intensity = random_cloud(seed, points)
        values = layers_of(xyz, intensity, GRID, LayerConfig()).values(LayerConfig(), GRID)
        np.testing.assert_allclose(values, naive_values(xyz, intensity, GRID, LayerConfig()), atol=2e-4, rtol=1e-5)


def test_what_stands_beside_a_block_is_no_ground_of_it() -> None:
    """A hedge with ground before it, and something behind the hedge whose own ground is hidden."""
    ground, hedge, behind = (7.5, 0.5, -0.7), (8.5, 0.5, 0.25), (9.5, 0.5, 0.42)
    xyz = np.array([ground, hedge, behind], np.float32)
    layers = layers_of(xyz, np.full(3, 100, np.float32), GridConfig(), LayerConfig())
    assert layers.points.sum() == 2, "hedge and what is behind"


def test_what_is_seen_alone_is_no_ground_near_the_robot() -> None:
    """A wall that one beam meets, with nothing below it: ground does not rise like that."""
    for away_m, seen in ((2.0, True), (5.0, True), (9.0, False)):
        y = np.linspace(-1, 1, 50, dtype=np.float32)
        xyz = np.stack([np.full(50, away_m, np.float32), y, np.zeros(50, np.float32)], axis=1)
        layers = layers_of(xyz, np.full(50, 200, np.float32), GridConfig(), LayerConfig())
        assert layers.points.sum() == (50 if seen else 0)


def test_a_scene_equals_a_loop_over_points() -> None:
    scene = scan_scene([Stand("wall", (3, -2), (3, 2)), Stand("grass", (-2, -2), (-2, 2), 1.0)], columns=360)
    config, grid = LayerConfig(), GridConfig()
    values = layers_of(scene.xyz, scene.intensity, grid, config).values(config, grid)
    np.testing.assert_allclose(values, naive_values(scene.xyz, scene.intensity, grid, config), atol=1e-5)


@pytest.mark.parametrize("reduction", list(Reduction))
def test_a_cloud_without_points_in_reach_makes_an_empty_map(reduction: Reduction) -> None:
    config = LayerConfig(reduction=reduction)
    far = np.array([[100, 0, 0], [0, -100, 0], [1, 1, 5], [np.nan, 0, 0], [5, 0, 0]], np.float32)
    for xyz in (np.zeros((0, 3), np.float32), far):
        layers = layers_of(xyz, np.full(len(xyz), 9, np.float32), GRID, config)
        assert not layers.values(config, GRID).any()
        assert not layers.points.any()


@settings(deadline=None)
@given(xyz=arrays(np.float32, st.tuples(st.integers(0, 40), st.just(3)), elements=st.floats(width=32)))
def test_any_points_are_counted_once_or_not_at_all(xyz: Cloud) -> None:
    with np.errstate(over="ignore"):
        layers = layers_of(xyz, np.full(len(xyz), 100, np.float32), GRID, LayerConfig(ground_margin_m=0.0))
    inside = (xyz >= -5).all(axis=1) & (xyz < 5).all(axis=1) & (np.abs(xyz[:, 2]) <= 0.5)
    assert layers.points.sum() == inside.sum()


def test_cells_begin_at_their_lower_edges() -> None:
    grid = GridConfig(cells=16, cell_m=0.5)
    edges = np.arange(-4, 4, 0.5, dtype=np.float32)
    xyz = np.stack([edges, edges, np.full(16, 0.3, np.float32)], axis=1)
    just_below = xyz[1:] - np.float32(1e-5)
    for cloud, expected in ((xyz, range(16)), (just_below, range(15))):
        points = layers_of(cloud, np.ones(len(cloud), np.float32), grid, LayerConfig(flat=FlatLayers.metric)).points
        assert np.argwhere(points.sum(axis=0)).tolist() == [[k, k] for k in expected]


def test_the_last_float_within_the_grid_is_in_the_last_cell() -> None:
    last = np.nextafter(np.float32(10), np.float32(0))
    ground = [[last, last, -0.7], [last, 0, -0.7], [-10, -10, -0.7]]
    xyz = np.array([[last, last, 0.3], [-10, -10, 0.3], [10, 0, 0.3], *ground], np.float32)
    points = layers_of(xyz, np.ones(6, np.float32), GridConfig(), LayerConfig()).points
    assert np.argwhere(points.sum(axis=0)).tolist() == [[0, 0], [199, 199]]


def test_a_lone_point_at_infinite_depth_is_no_ground() -> None:
    xyz = np.array([[2, 0, -0.74], [2.1, 0, -np.inf], [2, 0.1, -0.45]], np.float32)
    config = LayerConfig(height_m=1.0)
    assert layers_of(xyz, np.ones(3, np.float32), GRID, config).points.sum() == 1


def test_slopes_are_ground_and_what_stands_on_them_is_not() -> None:
    rng = np.random.default_rng(1)
    place = rng.uniform(-4, 4, (20000, 2))
    ground = np.column_stack([place, -0.75 + 0.08 * place[:, 0]])
    box = np.column_stack([rng.uniform(2.0, 2.3, 300), rng.uniform(0, 0.3, 300), rng.uniform(-0.25, 0.1, 300)])
    xyz = np.concatenate([ground, box]).astype(np.float32)
    points = layers_of(xyz, np.ones(len(xyz), np.float32), GRID, LayerConfig()).points
    assert points.sum() == 300


def test_steep_hills_are_ground_too_and_may_rise_to_the_sensor() -> None:
    rng = np.random.default_rng(2)
    place = rng.uniform(-6, 6, (40000, 2))
    xyz = np.column_stack([place, -0.75 + 0.15 * np.maximum(place[:, 0], -2.0)]).astype(np.float32)
    points = layers_of(xyz, np.ones(len(xyz), np.float32), GRID, LayerConfig()).points
    assert points[:, 8:22].sum() == 0


def test_values_without_their_largest_are_refused() -> None:
    layers = layers_of(np.zeros((0, 3), np.float32), np.zeros(0, np.float32), GRID, LayerConfig())
    with pytest.raises(ValueError, match="make them for max"):
        layers.values(LayerConfig(reduction=Reduction.max), GRID)
