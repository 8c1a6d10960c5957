"""Known steps: laws of the comparison between the driven and the predicted trajectory, and a plain loop as oracle."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.datasets.labels.known import known_steps
from navtool.pipeline.geometry.unicycle import rollout

FPS, HORIZON = 10, 10
Array = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Flags = np.ndarray[tuple[int, ...], np.dtype[np.bool_]]


def drive(state: Array) -> Array:
    """Poses of a robot that holds each row's speeds until the next row."""
    pose = np.zeros((len(state), 3))
    for row in range(1, len(state)):
        x, y, yaw = rollout(state[row - 1], 1, 1.0 / FPS)[0]
        cosine, sine = np.cos(pose[row - 1, 2]), np.sin(pose[row - 1, 2])
        pose[row] = pose[row - 1] + [cosine * x - sine * y, sine * x + cosine * y, yaw]
    return pose


def speeds(v_mps: float, omega_radps: float, rows: int) -> Array:
    return np.tile([v_mps, omega_radps], (rows, 1))


def all_valid(rows: int) -> Flags:
    return np.ones(rows, dtype=np.bool_)


def in_the_episode(rows: int) -> Flags:
    return np.arange(rows)[:, None] + np.arange(HORIZON) < rows


@given(v=st.floats(-2, 2), omega=st.floats(-2, 2), rows=st.integers(1, 40))
def test_constant_motion_is_all_known_up_to_the_end_of_the_episode(v: float, omega: float, rows: int) -> None:
    state = speeds(v, omega, rows)
    known = known_steps(drive(state), state, all_valid(rows), FPS, HORIZON, 1e-6)
    np.testing.assert_array_equal(known, in_the_episode(rows))


def test_a_sharp_turn_makes_the_later_steps_unknown() -> None:
    state = np.vstack([speeds(1.0, 0.0, 20), speeds(1.0, 3.0, 20)])
    known = known_steps(drive(state), state, all_valid(40), FPS, HORIZON, 0.1)
    assert known[:10].all()
    assert known[:, 0].all()
    # From row 15 the turn begins after 5 steps; 0.1 m to the side of the straight is 0.26 rad or 0.26 m further.
    assert known[15].tolist() == [True] * 8 + [False] * 2
    assert known[20:30].all()


@given(
    changes=st.lists(st.tuples(st.floats(-2, 2), st.floats(-2, 2)), min_size=1, max_size=25),
    invalid=st.sets(st.integers(0, 24), max_size=3),
    failed=st.sets(st.integers(0, 24), max_size=8),
    deviation=st.floats(0.01, 0.5),
)
def test_it_equals_a_plain_loop_over_rows_and_steps(
    changes: list[tuple[float, float]], invalid: set[int], failed: set[int], deviation: float
) -> None:
    state = np.array(changes)
    rows = len(state)
    pose, valid = drive(state), np.array([row not in invalid for row in range(rows)])
    outcome = np.array([int(row not in failed) for row in range(rows)], dtype=np.int64)
    known = known_steps(pose, state, valid, FPS, HORIZON, deviation, outcome)
    for row in range(rows):
        predicted = np.vstack([np.zeros(3), rollout(state[row], HORIZON - 1, 1.0 / FPS)])
        cosine, sine = np.cos(pose[row, 2]), np.sin(pose[row, 2])
        follows, fails = True, False
        for step in range(HORIZON):
            at = row + step
            if at >= rows or not valid[at]:
                assert not known[row, step:].any()
                break
            dx, dy = pose[at, :2] - pose[row, :2]
            driven = np.array([cosine * dx + sine * dy, -sine * dx + cosine * dy])
            follows = follows and bool(np.hypot(*(driven - predicted[step, :2])) <= deviation)
            fails = (fails or follows) and outcome[at] == 0
            assert known[row, step] == (follows or fails), (row, step)


@given(v=st.floats(-2, 2), omega=st.floats(-2, 2), turn=st.floats(-3.1, 3.1), shift=st.floats(-100, 100))
def test_it_does_not_depend_on_the_frame_of_the_poses(v: float, omega: float, turn: float, shift: float) -> None:
    state = np.vstack([speeds(v, omega, 8), speeds(omega, v, 12)])
    pose = drive(state)
    moved = pose.copy()
    moved[:, 0] = np.cos(turn) * pose[:, 0] - np.sin(turn) * pose[:, 1] + shift
    moved[:, 1] = np.sin(turn) * pose[:, 0] + np.cos(turn) * pose[:, 1] - shift
    moved[:, 2] += turn
    near = [known_steps(drive(state), state, all_valid(20), FPS, HORIZON, limit) for limit in (0.0499, 0.0501)]
    if (near[0] == near[1]).all():
        np.testing.assert_array_equal(known_steps(moved, state, all_valid(20), FPS, HORIZON, 0.05), near[0])


def test_a_wider_limit_never_knows_less_and_what_is_known_has_no_hole() -> None:
    state = np.random.default_rng(3).normal(0.5, 0.5, (60, 2))
    pose = drive(state)
    tight, wide = (known_steps(pose, state, all_valid(60), FPS, HORIZON, limit) for limit in (0.05, 0.2))
    assert (tight <= wide).all()
    assert (tight != wide).any()
    for known in (tight, wide):
        assert (known[:, 1:] <= known[:, :-1]).all()


def test_a_crash_stays_known_although_the_robot_stands_where_the_prediction_drives_on() -> None:
    state = np.vstack([speeds(1.0, 0.0, 20), speeds(0.0, 0.0, 20)])
    outcome = np.ones(40, dtype=np.int64)
    outcome[20:30] = 0
    without = known_steps(drive(state), state, all_valid(40), FPS, HORIZON, 0.25)
    crashed = known_steps(drive(state), state, all_valid(40), FPS, HORIZON, 0.25, outcome)
    assert not without[15, 9]
    assert crashed[15].all()
    assert (without <= crashed).all()
    # Where the same stop is no failure, what lies ahead was never tried.
    stopped = known_steps(drive(state), state, all_valid(40), FPS, HORIZON, 0.25, np.ones(40, dtype=np.int64))
    np.testing.assert_array_equal(stopped, without)


@pytest.mark.parametrize("rows", [0, 1])
def test_tiny_episodes(rows: int) -> None:
    known = known_steps(np.zeros((rows, 3)), np.zeros((rows, 2)), all_valid(rows), FPS, HORIZON, 0.1)
    assert known.shape == (rows, HORIZON)
    assert known[:, 0].all()
    assert not known[:, 1:].any()
