"""The lag between two records of one turning, and how far a sensor turned between two views."""

import numpy as np
import pytest
from turning_drive import walls

from navtool.pipeline.arrays import Array
from navtool.pipeline.time_offset import Turning, busiest, time_offset
from navtool.pipeline.turning import range_profile, shift_between, small_grey, turn_between

FINE = np.arange(0.0, 60.0, 0.001)
RATE = 0.4 * np.sin(0.9 * FINE + np.sin(0.31 * FINE)) + 0.3 * np.sin(0.5 * FINE**1.3)
ANGLE = np.concatenate([[0.0], np.cumsum((RATE[1:] + RATE[:-1]) / 2 * 0.001)])


def seen(step_s: float, lag_s: float = 0.0, noise_rad: float = 0.0, scale: float = 1.0) -> Turning:
    at = np.arange(0.0, 59.9, step_s)
    noise = np.random.default_rng(0).normal(size=at.size) * noise_rad
    return Turning(at + lag_s, scale * np.interp(at, FINE, ANGLE) + noise)


@pytest.mark.parametrize("lag_s", [0.0, 0.013, -0.25, 0.4, 1.37])
@pytest.mark.parametrize("noise_rad", [0.0, 0.003])
def test_the_lag_is_found_between_samples_of_any_rate(lag_s: float, noise_rad: float) -> None:
    for step_s in (0.01, 0.05, 0.1):
        found = time_offset(seen(0.01), seen(step_s, lag_s, noise_rad), 3.0)
        assert found is not None
        assert abs(found.lag_s - lag_s) < max(4 * found.sd_s, 0.005)
        assert found.correlation > 0.9


def test_scale_and_sign_are_found_beside() -> None:
    found = time_offset(seen(0.01), seen(0.05, 0.2, scale=-57.3), 3.0)
    assert found is not None
    assert abs(found.scale + 57.3) < 0.5
    assert found.correlation < -0.99


@pytest.mark.parametrize("angle", [0.4 * FINE, np.sin(2.0 * FINE), 0.0 * FINE, 0.001 * np.sin(FINE)])
def test_what_turns_steadily_or_again_and_again_tells_no_lag(angle: Array) -> None:
    assert time_offset(Turning(FINE[::10], angle[::10]), Turning(FINE[::50], angle[::50]), 4.0) is None


def test_two_motions_that_have_nothing_in_common_tell_no_lag() -> None:
    rng = np.random.default_rng(1)
    first, second = (Turning(FINE[::50], np.cumsum(rng.normal(size=1200)) * 0.02) for _ in range(2))
    assert time_offset(first, second, 3.0) is None


def test_the_busiest_stretch_is_where_the_turning_changes() -> None:
    angle = np.where(np.abs(FINE - 42.0) < 5, np.sin(3 * FINE), 0.0)
    start_s, end_s = busiest(Turning(FINE[::10], angle[::10]), 12.0)
    assert start_s <= 37.5
    assert end_s >= 46.5


@pytest.mark.parametrize("turn_rad", [0.0, 0.01, -0.1, 0.3])
@pytest.mark.parametrize("travel_m", [0.0, 0.1])
def test_clouds_tell_the_turn_whatever_the_travel(turn_rad: float, travel_m: float) -> None:
    before, after = range_profile(walls(0.3, 0.0, 0.0)), range_profile(walls(0.3 + turn_rad, travel_m, 0.02))
    assert before is not None
    assert after is not None
    assert abs(turn_between(before, after) - turn_rad) < 0.009


def test_pictures_move_to_the_right_where_the_camera_turns_left() -> None:
    scene = np.random.default_rng(2).integers(0, 255, (120, 400, 3), dtype=np.uint8)
    before, after = (small_grey(np.ascontiguousarray(scene[:, first : first + 160])) for first in (100, 92))
    assert abs(shift_between(before, after) * 160 - 8) < 0.5
