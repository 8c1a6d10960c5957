"""Which samples a picture of success predictions shows."""

import numpy as np
import pytest

from navtool.train.config import TrainConfig
from navtool.train.success.samples import SampleDataset, success_samples
from navtool.train.success.telling import telling_samples
from navtool.train.synthetic import SyntheticConfig, SyntheticSource


@pytest.fixture
def samples(small_config: TrainConfig, small_world: SyntheticConfig) -> SampleDataset:
    source = SyntheticSource(small_world)
    return success_samples(source, range(len(source.episodes)), small_config)


@pytest.mark.parametrize("count", [1, 2, 5, 6])
def test_half_of_them_have_a_failure_ahead(samples: SampleDataset, count: int) -> None:
    chosen = telling_samples(samples, count)
    assert len(chosen) == count
    assert (np.diff(chosen) > 0).all()
    failing = (samples.windows.known & (samples.windows.target == 0.0)).any(axis=1)
    assert int(failing[chosen].sum()) == count // 2


def test_where_few_are_fine_the_others_fill_up(samples: SampleDataset) -> None:
    assert telling_samples(samples, len(samples)) == list(range(len(samples)))
    assert len(telling_samples(samples, 10 * len(samples))) == len(samples)
