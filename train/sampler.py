"""The order of samples within an epoch."""

from collections.abc import Iterator

import numpy as np
from torch.utils.data import Sampler


class EpochSampler(Sampler[int]):
    """A permutation of 0..size-1 that is a function of (seed, epoch) alone.

    Guarantees:
        Every epoch has another order. An epoch's order depends on no other epoch, on no global random state and not on
        how often it is iterated: a resumed run sees what an uninterrupted one sees. Each index comes once an epoch,
        except that a last batch of a single sample is left out, as batch normalisation cannot learn from one.
    """

    def __init__(self, size: int, *, batch_size: int, seed: int) -> None:
        self._size = size
        self._length = size - 1 if size % batch_size == 1 and size > 1 and batch_size > 1 else size
        self._seed = seed
        self._epoch = 0

    def set_epoch(self, epoch: int) -> None:
        """Choose the epoch that the next iteration is for."""
        self._epoch = epoch

    def __len__(self) -> int:
        """Number of indices an epoch."""
        return self._length

    def __iter__(self) -> Iterator[int]:
        """The indices of the chosen epoch."""
        order = np.random.default_rng([self._seed, self._epoch]).permutation(self._size)
        return iter(order[: self._length].tolist())
