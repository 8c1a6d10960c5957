"""A cell's solidity is the threshold that it just passes."""

import numpy as np
import pytest
from intensity_scene import Stand, scan_scene

from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig, ObstacleConfig, Reduction
from navtool.pipeline.intensity_map.layer_points import sort_points
from navtool.pipeline.intensity_map.layers import intensity_layers
from navtool.pipeline.intensity_map.obstacles import TIE, find_obstacles
from navtool.pipeline.intensity_map.solidity import solidity

STANDS = [Stand("wall", (3.0, -2.0), (3.0, 2.0)), Stand("grass", (-3.0, -2.0), (-3.0, 2.0), 1.0)]


@pytest.mark.parametrize("reduction", list(Reduction))
@pytest.mark.parametrize("pooling", [0, 2])
def test_cells_are_solid_below_their_solidity_alone(reduction: Reduction, pooling: int) -> None:
    cloud = scan_scene(STANDS)
    grid, config = GridConfig(), LayerConfig(reduction=reduction)
    layers = intensity_layers(sort_points(cloud.xyz, cloud.intensity, grid, config), grid, config)
    solid = solidity(layers, grid, config, ObstacleConfig(pooling_cells=pooling))
    seen = layers.points.sum(axis=0) > 0
    np.testing.assert_array_equal(solid > 0, seen)
    # what is summed is compared with a slack of a rounding, which counts as much less as there is more to sum
    slack = TIE / (grid.cell_m**2 if reduction is Reduction.sum else 1)
    for threshold in np.quantile(solid[seen], [0.0, 0.2, 0.5, 0.9, 1.0]).tolist():
        obstacle = ObstacleConfig(threshold=threshold, pooling_cells=pooling)
        found = find_obstacles(layers, grid, config, obstacle).solid > 0
        assert found[seen & (solid > threshold + slack)].all()
        assert not found[solid < threshold - slack].any()


def test_a_wall_is_more_solid_than_grass() -> None:
    cloud = scan_scene(STANDS)
    grid, config = GridConfig(), LayerConfig()
    layers = intensity_layers(sort_points(cloud.xyz, cloud.intensity, grid, config), grid, config)
    solid = solidity(layers, grid, config, ObstacleConfig())
    wall, grass = solid[120:140][solid[120:140] > 0], solid[60:80][solid[60:80] > 0]
    assert wall.size > 20 < grass.size
    assert np.quantile(wall, 0.1) > np.quantile(grass, 0.9)
