import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.sim.legged.vibration import vibration_rms


@given(st.floats(0.1, 5.0), st.integers(5, 60))
def test_a_sine_has_its_root_mean_square_and_gravity_does_not_count(size: float, hertz: int) -> None:
    time_s = np.arange(1000) / 250.0
    force = np.stack([size * np.sin(2 * np.pi * hertz * time_s), 0 * time_s, 0 * time_s + 9.81], axis=-1)
    assert vibration_rms(force, 250) == pytest.approx(size / np.sqrt(2), rel=0.02)


def test_a_slow_lean_is_no_vibration() -> None:
    lean = 0.1 * np.sin(2 * np.pi * 0.02 * np.arange(5000) / 250.0)
    force = 9.81 * np.stack([np.sin(lean), 0 * lean, np.cos(lean)], axis=-1)
    assert vibration_rms(force, 250) < 0.1
