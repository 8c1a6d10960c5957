"""The unicycle's arcs: fine Euler steps as the oracle, continuity at zero turn rate, symmetries."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.pipeline.geometry.unicycle import poses_after, rollout

speeds = st.floats(-3, 3)
turn_rates = st.floats(-4, 4)


def euler(speed: float, turn_rate: float, duration_s: float, steps: int) -> NDArray[np.float64]:
    """The midpoint rule in many small steps."""
    dt = duration_s / steps
    yaw = turn_rate * dt * (np.arange(steps) + 0.5)
    return np.array([speed * dt * np.cos(yaw).sum(), speed * dt * np.sin(yaw).sum(), turn_rate * duration_s])


@settings(deadline=None)
@given(speed=speeds, turn_rate=turn_rates)
def test_agrees_with_small_steps(speed: float, turn_rate: float) -> None:
    poses = rollout(np.array([speed, turn_rate]), steps=10, dt_s=0.1)
    np.testing.assert_allclose(poses[-1], euler(speed, turn_rate, 1.0, 20_000), atol=1e-7)
    np.testing.assert_allclose(poses[4], euler(speed, turn_rate, 0.5, 20_000), atol=1e-7)


@settings(deadline=None)
@given(speed=speeds, exponent=st.floats(-300, -3))
def test_is_continuous_where_the_turn_rate_vanishes(speed: float, exponent: float) -> None:
    turn_rate = 10.0**exponent
    turning = rollout(np.array([speed, turn_rate]), steps=5, dt_s=0.2)
    straight = rollout(np.array([speed, 0.0]), steps=5, dt_s=0.2)
    np.testing.assert_allclose(turning, straight, atol=5 * turn_rate)
    # The sideways way of a gentle arc, to first order: v w t^2 / 2.
    assert turning[-1, 1] == pytest.approx(speed * turn_rate / 2, rel=1e-5, abs=1e-300)


@settings(deadline=None)
@given(speed=speeds, turn_rate=turn_rates, first_s=st.floats(0.01, 2), second_s=st.floats(0.01, 2))
def test_two_arcs_in_a_row_are_one(speed: float, turn_rate: float, first_s: float, second_s: float) -> None:
    velocity = np.array([speed, turn_rate])
    (x, y, yaw), whole = poses_after(velocity, np.array([first_s, first_s + second_s]))
    then_x, then_y, then_yaw = poses_after(velocity, np.array([second_s]))[0]
    cos, sin = np.cos(yaw), np.sin(yaw)
    joined = [x + cos * then_x - sin * then_y, y + sin * then_x + cos * then_y, yaw + then_yaw]
    np.testing.assert_allclose(whole, joined, atol=1e-9)


def test_symmetries_and_whole_turns() -> None:
    left = rollout(np.array([1.0, 0.7]), steps=6, dt_s=0.3)
    right = rollout(np.array([1.0, -0.7]), steps=6, dt_s=0.3)
    back = rollout(np.array([-1.0, -0.7]), steps=6, dt_s=0.3)
    np.testing.assert_allclose(right, left * [1, -1, -1], atol=1e-15)
    np.testing.assert_allclose(back, left * [-1, 1, -1], atol=1e-15)
    circle = rollout(np.array([2.0, 2 * np.pi]), steps=2, dt_s=1.0)
    np.testing.assert_allclose(circle, [[0, 0, 2 * np.pi], [0, 0, 4 * np.pi]], atol=1e-12)


def test_leading_axes_are_independent() -> None:
    velocities = np.random.default_rng(3).normal(size=(4, 3, 2)).astype(np.float32)
    poses = rollout(velocities, steps=7, dt_s=0.1)
    assert poses.shape == (4, 3, 7, 3)
    assert poses.dtype == np.float64
    np.testing.assert_array_equal(poses[2, 1], rollout(velocities[2, 1], steps=7, dt_s=0.1))


@pytest.mark.parametrize(("steps", "dt_s"), [(0, 0.1), (5, 0.0), (5, -0.1), (5, float("nan"))])
def test_refuses_a_horizon_of_nothing(steps: int, dt_s: float) -> None:
    with pytest.raises(ValueError, match=r"steps|dt_s"):
        rollout(np.array([1.0, 0.0]), steps=steps, dt_s=dt_s)
