"""The cost of trajectories against a loop over their points."""

import numpy as np

from navtool.pipeline.geometry.unicycle import rollout
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.planning_cost import obstacle_cost


def test_the_cost_of_trajectories_equals_a_loop() -> None:
    grid = GridConfig(cells=40, cell_m=0.2)
    rng = np.random.default_rng(4)
    plan = rng.random((40, 40), np.float32)
    velocity = np.column_stack([rng.uniform(-1, 2, 50), rng.uniform(-2, 2, 50)])
    trajectories = rollout(velocity, 40, 0.1)[..., :2].astype(np.float32)
    assert (np.abs(trajectories) > 4).any(), "some leave the map"
    expected = []
    for trajectory in trajectories.astype(float):
        cost = 0.0
        for x, y in trajectory:
            row, column = int(np.floor(x / 0.2 + 20)), int(np.floor(y / 0.2 + 20))
            if 0 <= row < 40 and 0 <= column < 40:
                cost += float(plan[row, column])
        expected.append(cost)
    np.testing.assert_allclose(obstacle_cost(plan, trajectories, grid), expected, rtol=1e-5)


def test_points_outside_the_map_cost_nothing() -> None:
    grid = GridConfig(cells=40, cell_m=0.2)
    beyond = np.array([[[4.01, 0], [-4.01, 0], [0, 4.01], [0, -4.01], [1e6, -1e6]]], np.float32)
    assert obstacle_cost(np.ones((40, 40), np.float32), beyond, grid).tolist() == [0]
