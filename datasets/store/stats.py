"""Statistics of columns in LeRobot's form: min, max, mean, std, count and quantiles, per episode and over all."""

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np
from jaxtyping import Num, Shaped, UInt8

from navtool.pipeline.arrays import Array

Stats = dict[str, list[Any]]
"""One column's statistics as JSON-ready nested lists."""

QUANTILES = {"q01": 0.01, "q10": 0.10, "q50": 0.50, "q90": 0.90, "q99": 0.99}
_LEVELS = 256


def column_stats(values: Shaped[Array, " rows *shape"]) -> Stats:
    """Statistics over the rows of a numeric or bool column, one value per element of a row.

    Args:
        values: At least one row; scalars per row give statistics of shape (1,).
    """
    table = values.astype(np.float64)
    if table.ndim == 1:
        table = table[:, None]
    stats: dict[str, Array] = {
        "min": table.min(axis=0),
        "max": table.max(axis=0),
        "mean": table.mean(axis=0),
        "std": table.std(axis=0),
    }
    quantiles = np.quantile(table, list(QUANTILES.values()), axis=0)
    stats |= dict(zip(QUANTILES, quantiles, strict=True))
    return {name: value.tolist() for name, value in stats.items()} | {"count": [len(table)]}


class ImageStats:
    """Running statistics of RGB frames per channel in [0, 1], shapes (3, 1, 1), exact up to the 8-bit levels.

    Every frame counts; of each, every fourth pixel along both axes.
    """

    def __init__(self) -> None:
        self.histogram = np.zeros((3, _LEVELS), dtype=np.int64)
        self.frames = 0

    def add(self, rgb: UInt8[Array, "height width 3"]) -> None:
        """Count one frame."""
        for number in range(3):
            self.histogram[number] += np.bincount(rgb[::4, ::4, number].reshape(-1), minlength=_LEVELS)
        self.frames += 1

    def merge(self, other: "ImageStats") -> None:
        """Count what the other has counted."""
        self.histogram += other.histogram
        self.frames += other.frames

    def result(self) -> Stats:
        """Statistics of what was counted; zeros when nothing was."""
        total = self.histogram.sum(axis=1)
        if not total.all():
            zeros: list[Any] = [[[0.0]]] * 3
            return dict.fromkeys(("min", "max", "mean", "std", *QUANTILES), zeros) | {"count": [0]}
        levels = np.arange(_LEVELS) / (_LEVELS - 1)
        cumulated = self.histogram.cumsum(axis=1)
        mean = self.histogram @ levels / total
        stats = {
            "min": levels[(self.histogram > 0).argmax(axis=1)],
            "max": levels[_LEVELS - 1 - (self.histogram[:, ::-1] > 0).argmax(axis=1)],
            "mean": mean,
            "std": np.sqrt(np.maximum(self.histogram @ levels**2 / total - mean**2, 0.0)),
        }
        stats |= {
            name: levels[(cumulated >= share * total[:, None]).argmax(axis=1)] for name, share in QUANTILES.items()
        }
        return {name: value.reshape(3, 1, 1).tolist() for name, value in stats.items()} | {"count": [self.frames]}


def aggregate(episodes: Sequence[Mapping[str, Stats]]) -> dict[str, Stats]:
    """The statistics of all episodes together, weighted by their counts.

    Exact for all but the quantiles, which are the weighted means of the episodes' quantiles, as LeRobot's are. One
    episode is added after the other: the result is the same, to the last digit, whether that happens at once or not.
    """
    keys = dict.fromkeys(key for episode in episodes for key in episode)
    each = {key: [episode[key] for episode in episodes if key in episode] for key in keys}
    return {key: reduce(lambda before, added: _merge([before, added]), parts) for key, parts in each.items()}


def _merge(parts: Sequence[Stats]) -> Stats:
    counts = np.array([part["count"] for part in parts], dtype=np.float64).ravel()
    if counts.sum() == 0:
        return parts[0]
    counted = [part for part, count in zip(parts, counts, strict=True) if count > 0]
    weights = counts[counts > 0] / counts.sum()

    def stacked(name: str) -> Num[Array, " episodes *shape"]:
        return np.array([part[name] for part in counted], dtype=np.float64)

    means = stacked("mean")
    mean = np.tensordot(weights, means, axes=1)
    variance = np.tensordot(weights, stacked("std") ** 2 + (means - mean) ** 2, axes=1)
    merged = {
        "min": stacked("min").min(axis=0),
        "max": stacked("max").max(axis=0),
        "mean": mean,
        "std": np.sqrt(variance),
    }
    merged |= {name: np.tensordot(weights, stacked(name), axes=1) for name in QUANTILES}
    return {name: value.tolist() for name, value in merged.items()} | {"count": [int(counts.sum())]}
