import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.sim.world.obstacle import Obstacle, Obstacles
from navtool.sim.world.surfaces import surface_number

ROCK, GRASS = surface_number("rock"), surface_number("tall_grass")


@given(
    st.floats(-3, 3), st.floats(-3, 3), st.floats(0.2, 2), st.floats(0.1, 1), st.floats(0, 3.1), st.integers(0, 1000)
)
def test_the_distance_of_a_rectangle_is_that_of_the_nearest_point_of_its_outline(
    x: float, y: float, length: float, width: float, yaw: float, seed: int
) -> None:
    item = Obstacle(
        kind="wall",
        surface=ROCK,
        x_m=x,
        y_m=y,
        half_length_m=length,
        half_width_m=width,
        yaw_rad=yaw,
        height_m=1.0,
    )
    t = np.linspace(-1, 1, 2001)
    sides = [np.stack([t * length, s * width + 0 * t]) for s in (-1, 1)]
    sides += [np.stack([s * length + 0 * t, t * width]) for s in (-1, 1)]
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    rim = turn @ np.concatenate(sides, axis=1) + [[x], [y]]
    points = np.random.default_rng(seed).uniform(-6, 6, (2, 20))
    nearest = np.hypot(*(points[:, :, None] - rim[:, None, :])).min(axis=1)
    found = Obstacles((item,)).clearance(*points)
    assert np.abs(found) == pytest.approx(nearest, abs=2e-3)
    local = turn.T @ (points - [[x], [y]])
    inside = (np.abs(local[0]) < length) & (np.abs(local[1]) < width)
    assert ((found < 0) == inside)[nearest > 1e-3].all()


def test_a_circle_and_the_nearest_of_several() -> None:
    rocks = tuple(
        Obstacle(kind="rock", surface=ROCK, x_m=x, y_m=0.0, half_length_m=0.5, height_m=0.4) for x in (0.0, 4.0)
    )
    found = Obstacles(rocks).clearance(np.array([[1.0, 3.5], [2.0, 4.0]]), np.zeros((2, 2)))
    assert found == pytest.approx(np.array([[0.5, 0.0], [1.5, -0.5]]))


def test_what_yields_and_what_does_not() -> None:
    items = tuple(
        Obstacle(kind="x", surface=surface, x_m=0.0, y_m=0.0, half_length_m=1.0, height_m=1.0)
        for surface in (ROCK, GRASS, GRASS)
    )
    everything = Obstacles(items)
    assert len(everything.only(pliable=True).items) == 2
    assert everything.only(pliable=False).items == items[:1]


def test_nothing_is_infinitely_far_away() -> None:
    assert Obstacles(()).clearance(np.zeros(3), np.zeros(3)) == pytest.approx(np.full(3, np.inf))
