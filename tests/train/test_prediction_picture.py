"""Which samples a run's picture shows."""

import numpy as np
import pytest

from navtool.train.config import TrainConfig
from navtool.train.prediction_picture import some_windows
from navtool.train.synthetic import SyntheticConfig, SyntheticSource
from navtool.train.windows import Windows, plan_windows


@pytest.fixture
def windows(small_config: TrainConfig, small_world: SyntheticConfig) -> Windows:
    source = SyntheticSource(small_world)
    return plan_windows(source, range(len(source.episodes)), small_config.data)


def failing(windows: Windows) -> int:
    return int((windows.known & (windows.target == 0.0)).any(axis=1).sum())


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_half_of_them_have_a_failure_ahead(windows: Windows, count: int) -> None:
    some = some_windows(windows, count)
    assert len(some) == count
    assert failing(some) == count // 2
    assert (np.diff(some.row) > 0).all()
    assert set(some.row) <= set(windows.row)


def test_where_few_are_fine_the_others_fill_up(windows: Windows) -> None:
    everything = some_windows(windows, len(windows))
    np.testing.assert_array_equal(everything.row, windows.row)
    np.testing.assert_array_equal(everything.target, windows.target)
    assert len(some_windows(windows, 10 * len(windows))) == len(windows)
