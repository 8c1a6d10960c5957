"""Predicted success, held against what is known about it."""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from navtool.train.success.loss import masked_mse
from navtool.train.success.samples import Sample


@dataclass(frozen=True, slots=True)
class Predictions:
    """Success probabilities of samples with their targets, as arrays."""

    row: NDArray[np.int64]
    """Rows of the data set, (n,)."""
    probability: NDArray[np.float32]
    """E-hat, (n, T)."""
    target: NDArray[np.float32]
    """E, (n, T)."""
    known: NDArray[np.bool_]
    """(n, T)."""

    def loss(self) -> float:
        """The masked squared error over all samples, however they were batched."""
        arrays = (self.probability, self.target, self.known)
        prediction, target, known = (torch.from_numpy(array) for array in arrays)
        return float(masked_mse(prediction, target, known))


class PredictionLog:
    """Collects predictions batch by batch; of a batch it keeps neither images nor clouds."""

    def __init__(self) -> None:
        self._parts: list[tuple[Tensor, Tensor, Tensor, Tensor]] = []

    def add(self, batch: Sample, probability: Tensor) -> None:
        """Take the probabilities [B, T] that were predicted for a batch."""
        tensors = (batch.row, probability.detach().float(), batch.target, batch.known)
        row, kept, target, known = (tensor.cpu() for tensor in tensors)
        self._parts.append((row, kept, target, known))

    def predictions(self) -> Predictions:
        """All that was taken, in that order; at least one batch."""
        row, probability, target, known = (torch.cat(part).numpy() for part in zip(*self._parts, strict=True))
        return Predictions(row, probability, target, known)
