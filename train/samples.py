"""What a model learns from: samples planned for some episodes, and batches of them."""

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from torch import Tensor
from torch.utils.data import Dataset

type Batch = tuple[Tensor, ...]
"""Tensors of one sample, or of several with a leading batch axis: a NamedTuple, which loaders know to stack."""


@dataclass(frozen=True, slots=True)
class SampleReport:
    """How many rows became samples, and why the others did not."""

    rows: int
    """Rows of the episodes looked at."""
    samples: int
    """Rows that are samples."""
    excluded: dict[str, int]
    """Other rows by reason."""

    def reasons(self) -> str:
        """The reasons that occurred, with their counts; empty where none did."""
        return ", ".join(f"{count} {reason}" for reason, count in self.excluded.items() if count)

    def cure(self) -> str:
        """What gives more samples."""
        return "record more"


class Samples[BatchT: Batch](Dataset[BatchT], ABC):
    """The samples of some episodes, in the order of their rows; each is made when it is asked for.

    A sample depends on its data and the configuration alone, not on what was read before. Loader processes get copies,
    so that it must survive pickling.
    """

    row: NDArray[np.int64]
    """Row of each sample in its source, (n,)."""
    episode: NDArray[np.int64]
    """Episode of each sample, (n,)."""
    report: SampleReport
    """What was left out."""

    def __len__(self) -> int:
        """Number of samples."""
        return len(self.row)

    @abstractmethod
    def __getitem__(self, index: int) -> BatchT:
        """A sample."""
