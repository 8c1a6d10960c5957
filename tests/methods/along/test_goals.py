"""Directions of goals: where the robot itself drove, or a fixed place."""

import numpy as np
import pytest

from navtool.base.setting_error import SettingError
from navtool.datasets.streams.motion import Motion
from navtool.methods.along.config import GoalConfig
from navtool.methods.along.goals import goal_direction
from navtool.pipeline.geometry.transforms import quaternion_from_rpy


def way(points: list[tuple[float, float]]) -> Motion:
    """A robot that is at one point a second."""
    xyz = np.column_stack([np.array(points), np.zeros(len(points))])
    level = np.tile(quaternion_from_rpy(np.zeros(3)), (len(points), 1))
    return Motion(np.arange(len(points), dtype=np.int64) * 10**9, xyz, level, 2.0)


CORNER = way([(0.0, 0.0), (2.0, 0.0), (4.0, 0.0), (4.0, 2.0), (4.0, 4.0), (4.0, 6.0)])


def test_the_goal_is_the_first_place_on_the_way_that_is_far_enough() -> None:
    toward = goal_direction(CORNER, 0, np.zeros(3), GoalConfig(ahead_m=5.0))
    assert toward == pytest.approx(np.arctan2(4.0, 4.0))
    assert goal_direction(CORNER, 0, np.zeros(3), GoalConfig(ahead_m=1.5)) == 0.0


def test_the_direction_is_in_the_frame_of_the_map() -> None:
    turned = np.array([0.0, 0.0, np.pi / 2])
    assert goal_direction(CORNER, 0, turned, GoalConfig(ahead_m=1.5)) == pytest.approx(-np.pi / 2)
    behind = np.array([0.0, 0.0, 3.0])
    assert abs(goal_direction(CORNER, 0, behind, GoalConfig(ahead_m=5.0))) <= np.pi


def test_a_way_that_ends_sooner_has_its_end_for_goal_and_the_end_looks_ahead() -> None:
    at = np.array([4.0, 2.0, 0.0])
    assert goal_direction(CORNER, 3 * 10**9, at, GoalConfig(ahead_m=50.0)) == pytest.approx(np.pi / 2)
    assert goal_direction(CORNER, 5 * 10**9, np.array([4.0, 6.0, 1.0]), GoalConfig()) == 0.0


def test_a_sensor_beside_the_base_looks_the_same_way() -> None:
    beside = np.array([0.0, 1.0, 0.0])
    config = GoalConfig(ahead_m=1.5)
    assert goal_direction(CORNER, 0, beside, config) == goal_direction(CORNER, 0, np.zeros(3), config)


def test_a_fixed_goal_is_that_of_the_odometry_frame() -> None:
    config = GoalConfig(odom_m=[1.0, 3.0])
    assert goal_direction(None, 0, np.array([1.0, 1.0, 0.5]), config) == pytest.approx(np.pi / 2 - 0.5)


def test_without_a_place_it_is_straight_on() -> None:
    assert goal_direction(CORNER, 0, None, GoalConfig()) == 0.0
    assert goal_direction(None, 0, np.zeros(3), GoalConfig()) == 0.0


@pytest.mark.parametrize("odom_m", [[1.0], [1.0, 2.0, 3.0], [np.nan, 0.0]])
def test_half_a_goal_is_refused(odom_m: list[float]) -> None:
    with pytest.raises(SettingError, match=r"odom_m: .*\n.*\[x, y\]"):
        GoalConfig(odom_m=odom_m)
    with pytest.raises(SettingError, match=r"ahead_m: 0\.1 m is outside \[0\.5, 100\] m"):
        GoalConfig(ahead_m=0.1)
