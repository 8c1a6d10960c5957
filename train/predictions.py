"""What a network says about samples, held against what is known about them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from navtool.train.loss import masked_mse
from navtool.train.samples import Sample

type Scorer = Callable[[Tensor, Tensor, Tensor, Tensor, Tensor, Tensor], Tensor]
"""A network's forward: `Sample.inputs` to success probabilities [B, T]."""


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


def predict(score: Scorer, batches: Iterable[Sample], device: torch.device) -> Predictions:
    """Score all batches without gradients; the network must be in evaluation mode already."""
    log = PredictionLog()
    with torch.inference_mode():
        for batch in batches:
            image, points, point_count, velocity, trajectory, reliability = (t.to(device) for t in batch.inputs())
            log.add(batch, score(image, points, point_count, velocity, trajectory, reliability))
    return log.predictions()
