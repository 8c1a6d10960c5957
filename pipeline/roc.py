"""How well a threshold on one figure separates two kinds, for every threshold at once."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float64

from navtool.pipeline.arrays import Array


class RocPoint(NamedTuple):
    """One threshold of a curve."""

    threshold: float
    true_positive_rate: float
    """Share of the positives above it."""
    false_positive_rate: float
    """Share of the negatives above it."""


class Roc(NamedTuple):
    """The receiver operating characteristic of one figure; thresholds fall, both rates rise from 0 to 1."""

    threshold: Float64[Array, " t"]
    """Each lies midway between two neighbouring figures; the first is infinite, the last lies below all."""
    true_positive_rate: Float64[Array, " t"]
    false_positive_rate: Float64[Array, " t"]

    @property
    def area(self) -> float:
        """Under the curve: how often a positive has the larger figure, equal ones counted half. 0.5 is chance."""
        return float(np.trapezoid(self.true_positive_rate, self.false_positive_rate))

    def best(self) -> RocPoint:
        """Where the difference of the rates is largest (Youden's J), however many there are of each kind.

        Of several, the one in the middle: it is the farthest from those that are worse.
        """
        gain = self.true_positive_rate - self.false_positive_rate
        equal = np.flatnonzero(gain[1:] >= gain[1:].max() - 1e-12) + 1
        at = int(equal[equal.size // 2])
        return RocPoint(
            float(self.threshold[at]), float(self.true_positive_rate[at]), float(self.false_positive_rate[at])
        )


def roc(positives: Float[Array, " p"], negatives: Float[Array, " m"]) -> Roc:
    """The curve of a figure that is larger for positives.

    Raises:
        ValueError: There are no positives or no negatives, or a figure is not finite.
    """
    if not positives.size or not negatives.size:
        raise ValueError(f"{positives.size} positives and {negatives.size} negatives: a curve needs both")
    figures = np.concatenate([positives, negatives]).astype(np.float64)
    if not np.isfinite(figures).all():
        raise ValueError("the figures have to be finite")
    order = np.argsort(-figures, kind="stable")
    figures, kind = figures[order], order < positives.size
    # a threshold lies between two different figures only
    last = np.append(np.flatnonzero(np.diff(figures)), figures.size - 1)
    following = np.append(figures[1:], 2 * figures[-1] - figures[0] - 1.0)
    found = np.cumsum(kind)[last]
    threshold = 0.5 * (figures[last] + following[last])
    return Roc(
        np.concatenate([[np.inf], threshold]),
        np.concatenate([[0.0], found / positives.size]),
        np.concatenate([[0.0], (last + 1 - found) / negatives.size]),
    )
