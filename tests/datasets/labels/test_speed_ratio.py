"""The ratio of driven distance by poses and by speeds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.datasets.labels.speed_ratio import speed_ratio

ROWS, FPS = 100, 10


@given(v=st.floats(0.3, 3.0), scale=st.floats(0.5, 2.0), yaw=st.floats(-3, 3), sign=st.sampled_from([-1.0, 1.0]))
def test_it_is_the_scale_between_the_two(v: float, scale: float, yaw: float, sign: float) -> None:
    distance = sign * scale * v * np.arange(ROWS) / FPS
    pose = np.column_stack([distance * np.cos(yaw), distance * np.sin(yaw), np.full(ROWS, yaw)])
    state = np.tile([sign * v, 0.0], (ROWS, 1))
    assert speed_ratio(pose, state, np.ones(ROWS, dtype=np.bool_), FPS) == pytest.approx(scale)


def test_rows_that_stand_or_are_not_valid_do_not_count() -> None:
    state = np.tile([1.0, 0.0], (ROWS, 1))
    pose = np.zeros((ROWS, 3))
    pose[:, 0] = np.arange(ROWS) / FPS
    pose[50:, 0] += 100.0
    valid = np.arange(ROWS) != 50
    state[80:] = 0.0
    pose[80:, 0] = pose[79, 0]
    assert speed_ratio(pose, state, valid, FPS) == pytest.approx(1.0)
    assert speed_ratio(pose, state * 0.1, valid, FPS) is None
    assert speed_ratio(pose, state, np.arange(ROWS) < 10, FPS) is None
