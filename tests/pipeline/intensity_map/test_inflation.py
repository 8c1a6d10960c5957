"""Inflation: SciPy's convolution as oracle, directions, a door."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.signal import convolve2d

from navtool.pipeline.intensity_map.config import Inflation, InflationConfig
from navtool.pipeline.intensity_map.inflation import inflate, inflation_kernel, planning_map
from navtool.pipeline.intensity_map.obstacles import Obstacles

EIGHT = [k * np.pi / 4 for k in range(8)]


def sparse(seed: int, cells: int, share: float) -> NDArray[np.float32]:
    rng = np.random.default_rng(seed)
    return np.where(rng.random((cells, cells)) < share, rng.random((cells, cells)), 0).astype(np.float32)


@pytest.mark.parametrize("size", [1, 3, 11, 13, 25, 41])
@pytest.mark.parametrize("method", list(Inflation))
def test_inflation_equals_a_plain_convolution(size: int, method: Inflation) -> None:
    config = InflationConfig(method=method, size_cells=size, padding_cells=0, minor_cells=min(2, size // 2))
    for seed, share in enumerate((0.0, 0.01, 0.3)):
        values, kernel = sparse(seed, 60, share), inflation_kernel(0.7, config)
        grown, expected = inflate(values, kernel), convolve2d(values, kernel, mode="same")
        np.testing.assert_allclose(grown, expected, atol=1e-5, rtol=1e-5)
        np.testing.assert_array_equal(grown > 0, expected > 0)


@settings(deadline=None, max_examples=40)
@given(
    values=arrays(np.float32, (12, 12), elements=st.sampled_from([0.0, 0.25, 1.0])),
    kernel=arrays(np.float32, (5, 5), elements=st.sampled_from([0.0, 1.0])),
)
def test_any_kernel_is_convolved_not_correlated(values: NDArray[np.float32], kernel: NDArray[np.float32]) -> None:
    np.testing.assert_array_equal(inflate(values, kernel), convolve2d(values, kernel, mode="same"))


@pytest.mark.parametrize("goal_rad", EIGHT)
def test_obstacles_grow_opposite_to_the_goal(goal_rad: float) -> None:
    config = InflationConfig(size_cells=21, padding_cells=1, minor_cells=2)
    values = np.zeros((81, 81), np.float32)
    values[40, 40] = 1
    offset = np.argwhere(inflate(values, inflation_kernel(goal_rad, config))) - 40
    goal = np.array([np.cos(goal_rad), np.sin(goal_rad)])
    towards, aside = offset @ goal, np.abs(offset @ [-goal[1], goal[0]])
    assert towards.min() <= -9.5, "the whole reach of the kernel, away from the goal"
    assert towards.max() <= config.minor_cells + 1e-9, "no more than a little towards it"
    far = towards < -config.minor_cells
    assert aside[far].max() <= config.padding_cells + 0.5
    # thick all along: at each distance the line itself and its neighbours are there
    for distance in np.arange(0, 9.5):
        near_line = np.abs(towards + distance) < 0.75
        assert (aside[near_line] < 0.5).any()
        assert np.count_nonzero(near_line) >= 3


@pytest.mark.parametrize("goal_rad", EIGHT)
def test_an_obstacle_on_the_way_grows_towards_the_robot(goal_rad: float) -> None:
    values = np.zeros((81, 81), np.float32)
    obstacle = 40 + np.round(20 * np.array([np.cos(goal_rad), np.sin(goal_rad)])).astype(int)
    values[tuple(obstacle)] = 1
    grown = np.argwhere(inflate(values, inflation_kernel(goal_rad, InflationConfig()))) - 40
    nearest = np.hypot(*grown.T).min()
    assert nearest < 20 - 4


@given(quarter=st.integers(0, 3), goal_rad=st.floats(-3.1, 3.1))
def test_a_quarter_turn_of_the_goal_turns_the_kernel(quarter: int, goal_rad: float) -> None:
    config = InflationConfig(size_cells=15)
    turned = inflation_kernel(goal_rad + quarter * np.pi / 2, config)
    # rounding may decide differently for cells whose middle lies on an edge
    assert np.count_nonzero(turned != np.rot90(inflation_kernel(goal_rad, config), quarter)) <= 4


def free_regions(plan: NDArray[np.float32]) -> NDArray[np.int32]:
    return np.asarray(label(plan == 0)[0], np.int32)


@pytest.mark.parametrize("goal_rad", [0.0, 0.1, -0.1])
def test_a_door_stays_open_with_adaptive_and_closes_with_uniform_inflation(goal_rad: float) -> None:
    solid = np.zeros((200, 200), np.float32)
    solid[130, :] = 1
    solid[130, 96:105] = 0  # 0.9 m
    nothing = np.zeros_like(solid)
    obstacles = Obstacles(solid, nothing, solid > 0)
    joined = {}
    for method in Inflation:
        kernel = inflation_kernel(goal_rad, InflationConfig(method=method))
        regions = free_regions(planning_map(obstacles, nothing > 0, kernel))
        joined[method] = regions[100, 100] == regions[160, 100] != 0
    assert joined == {Inflation.adaptive: True, Inflation.uniform: False}


def test_the_plan_holds_inflated_solids_and_panes_and_pliables_as_they_are() -> None:
    solid, pliable = 2 * sparse(0, 40, 0.02), sparse(1, 40, 0.1)
    pliable[solid > 0] = 0
    transparent = sparse(2, 40, 0.02) + (solid > 1.5) > 0
    kernel = inflation_kernel(1.0, InflationConfig())
    plan = planning_map(Obstacles(solid, pliable, solid + pliable > 0), transparent, kernel)
    hard = np.maximum(solid, transparent)
    np.testing.assert_allclose(plan, np.maximum(convolve2d(hard, kernel, mode="same"), pliable), atol=1e-6)


def test_kernels_larger_than_the_grid_and_goals_nowhere_are_refused() -> None:
    with pytest.raises(ValueError, match="smaller than the inflation kernel"):
        inflate(np.zeros((10, 10), np.float32), np.ones((11, 11), np.float32))
    with pytest.raises(ValueError, match="finite"):
        inflation_kernel(float("nan"), InflationConfig())
