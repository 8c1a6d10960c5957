"""The tensor path against the NumPy path, eager and scripted, alone and in a batch."""

import numpy as np
import pytest
import torch
from intensity_scene import SceneCloud, Stand, scan_scene
from torch import Tensor

from navtool.pipeline.intensity_map.config import (
    FlatLayers,
    GridConfig,
    Inflation,
    InflationConfig,
    IntensityMapConfig,
    LayerConfig,
    ObstacleConfig,
    Reduction,
)
from navtool.pipeline.intensity_map.inflation import inflation_kernel, planning_map
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import intensity_layers
from navtool.pipeline.intensity_map.obstacles import cell_classes, find_obstacles
from navtool.pipeline.intensity_map.tensor_map import TensorIntensityMap, TensorMap

DEVICES = ["cpu", *(["cuda"] if torch.cuda.is_available() else [])]
GOALS = [0.0, 0.7, -2.0, 3.0, 1.5]

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit:DeprecationWarning")


def random_cloud(seed: int, points: int = 2500) -> SceneCloud:
    rng = np.random.default_rng(seed)
    xyz = rng.uniform([-12, -12, -0.9], [12, 12, 0.7], (points, 3))
    xyz[::3, 2] *= 0.1
    xyz[rng.integers(0, points, 40), rng.integers(0, 3, 40)] = rng.choice([np.nan, np.inf, -np.inf], 40)
    intensity = np.round(rng.uniform(-5, 260, points))
    intensity[rng.integers(0, points, 20)] = rng.choice([np.nan, np.inf, -np.inf], 20)
    return SceneCloud(xyz.astype(np.float32), intensity.astype(np.float32))


def clouds() -> list[SceneCloud]:
    scene = [
        Stand("wall", (4, -1), (4, 1)),
        Stand("grass", (-1, 3), (2, 3), 1.2),
        Stand("glass", (-3, -2), (-3, 2)),
        Stand("beads", (1, -3), (-1, -3), 2.0),
    ]
    nothing = SceneCloud(np.zeros((0, 3), np.float32), np.zeros(0, np.float32))
    return [random_cloud(0), scan_scene(scene, 1, 450), nothing, random_cloud(2, 900), random_cloud(3, 120)]


def masks(cells: int) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.random.default_rng(5).random((len(GOALS), cells, cells)) < 0.001


def batch(cells: int, device: str = "cpu") -> list[Tensor]:
    """The clouds, padded with points that would count."""
    all_clouds = clouds()
    size = max(len(cloud.xyz) for cloud in all_clouds) + 7
    xyz, intensity = np.full((len(all_clouds), size, 3), 0.3, np.float32), np.full((len(all_clouds), size), 255.0)
    for k, cloud in enumerate(all_clouds):
        xyz[k, : len(cloud.xyz)] = cloud.xyz
        intensity[k, : len(cloud.xyz)] = cloud.intensity
    counts = torch.tensor([len(cloud.xyz) for cloud in all_clouds])
    parts = [torch.from_numpy(xyz), torch.from_numpy(intensity.astype(np.float32)), counts]
    return [part.to(device) for part in (*parts, torch.tensor(GOALS), torch.from_numpy(masks(cells)))]


def assert_equals_numpy(found: TensorMap, config: IntensityMapConfig) -> None:
    grid = config.grid
    for k, cloud in enumerate(clouds()):
        points = sort_points(cloud.xyz, cloud.intensity, grid, config.layers)
        layers = intensity_layers(points, grid, config.layers)
        obstacles = find_obstacles(layers, grid, config.layers, config.obstacles)
        mask = masks(grid.cells)[k]
        plan = planning_map(obstacles, mask, inflation_kernel(GOALS[k], config.inflation))
        np.testing.assert_array_equal(found.points[k].cpu(), layers.points)
        np.testing.assert_allclose(found.total[k].cpu(), layers.total, atol=1e-5)
        np.testing.assert_array_equal(found.classes[k].cpu(), cell_classes(obstacles, mask))
        np.testing.assert_allclose(found.solid[k].cpu(), obstacles.solid, rtol=1e-5)
        np.testing.assert_allclose(found.pliable[k].cpu(), obstacles.pliable, rtol=1e-5)
        np.testing.assert_allclose(found.plan[k].cpu(), plan, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("reduction", list(Reduction))
@pytest.mark.parametrize("pooling", [0, 2])
def test_maps_equal_those_of_numpy(reduction: Reduction, pooling: int, device: str) -> None:
    threshold = 20.0 if reduction is Reduction.sum else 0.57
    config = IntensityMapConfig(
        layers=LayerConfig(reduction=reduction),
        obstacles=ObstacleConfig(threshold=threshold, pooling_cells=pooling),
    )
    found = TensorIntensityMap(config).to(device)(*batch(config.grid.cells, device))
    assert_equals_numpy(found, config)
    assert set(found.classes.unique().tolist()) == {0, 1, 2, 3}


@pytest.mark.parametrize(
    "config",
    [
        IntensityMapConfig(layers=LayerConfig(flat=FlatLayers.metric, ground_margin_m=0.0)),
        IntensityMapConfig(inflation=InflationConfig(method=Inflation.uniform, size_cells=15)),
        IntensityMapConfig(grid=GridConfig(cells=46, cell_m=0.25), layers=LayerConfig(height_m=0.3)),
        # half of it is 3.5 m in a single, and a little more in a double: 7 or 8 blocks of ground
        IntensityMapConfig(grid=GridConfig(cells=100, cell_m=0.07)),
    ],
)
def test_other_settings_equal_numpy_too(config: IntensityMapConfig) -> None:
    assert_equals_numpy(TensorIntensityMap(config)(*batch(config.grid.cells)), config)


@pytest.mark.parametrize("reduction", list(Reduction))
def test_scripted_equals_eager(reduction: Reduction) -> None:
    config = IntensityMapConfig(layers=LayerConfig(reduction=reduction))
    eager = TensorIntensityMap(config)
    scripted = torch.jit.script(eager)
    inputs = batch(config.grid.cells)
    for _ in range(3):  # the second and third call are optimised
        for mine, other in zip(eager(*inputs), scripted(*inputs), strict=True):
            torch.testing.assert_close(mine, other, rtol=1e-6, atol=1e-6)


def test_a_cloud_has_the_same_map_alone_and_among_others() -> None:
    config = IntensityMapConfig()
    mapper, inputs = TensorIntensityMap(config), batch(config.grid.cells)
    together = mapper(*inputs)
    for k in range(len(GOALS)):
        count = int(inputs[2][k])
        alone = mapper(*(part[k : k + 1, :count] if i < 2 else part[k : k + 1] for i, part in enumerate(inputs)))
        torch.testing.assert_close(alone.classes[0], together.classes[k])
        torch.testing.assert_close(alone.plan[0], together.plan[k], rtol=1e-6, atol=1e-6)
