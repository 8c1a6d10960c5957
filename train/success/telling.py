"""Which samples a picture of success predictions shows."""

import numpy as np
from numpy.typing import NDArray

from navtool.train.success.samples import SampleDataset


def telling_samples(samples: SampleDataset, count: int) -> list[int]:
    """Samples with a known failure ahead and others, half of each where there are enough, evenly over all."""
    windows = samples.windows
    fails = (windows.known & (windows.target == 0.0)).any(axis=1)
    failing, fine = np.flatnonzero(fails), np.flatnonzero(~fails)
    most = max(count // 2, count - fine.size)
    few = _evenly(failing, min(most, failing.size))
    return sorted([*few.tolist(), *_evenly(fine, min(count - few.size, fine.size)).tolist()])


def _evenly(indices: NDArray[np.int64], count: int) -> NDArray[np.int64]:
    return np.asarray(indices[np.linspace(0, indices.size - 1, count).round().astype(np.int64)])
