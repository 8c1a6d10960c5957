"""Decoded frames and clouds in memory: random order makes files slow to read, and each epoch wants the same rows."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from navtool.train.source import NavSource, column_or

_MIB = 1024 * 1024


class RowCache:
    """Arrays of as many of the given rows as fit, read once in the order of rows.

    Loader processes share the memory: the arrays are one tensor. Which rows are held is a function of the arguments.
    """

    def __init__(self, read: Callable[[int], NDArray[np.generic]], rows: Sequence[int], limit_bytes: int) -> None:
        wanted = np.unique(np.asarray(rows, dtype=np.int64))
        size = read(int(wanted[0])).nbytes if wanted.size and limit_bytes else 1
        self._rows = wanted[: limit_bytes // size]
        held = [torch.from_numpy(np.array(read(row))) for row in self._rows.tolist()]
        self._arrays = torch.stack(held) if held else torch.empty(0)

    def __len__(self) -> int:
        """Number of rows held."""
        return len(self._rows)

    @property
    def nbytes(self) -> int:
        """Memory that the arrays take."""
        return self._arrays.nbytes

    def get(self, row: int) -> Tensor | None:
        """The array of a row, not to be written to; None where it is not held."""
        slot = int(np.searchsorted(self._rows, row))
        return self._arrays[slot] if slot < len(self._rows) and self._rows[slot] == row else None


class SampleCaches(NamedTuple):
    """What is held of the rows of a data set."""

    clouds: RowCache
    images: RowCache


def fill_caches(source: NavSource, rows: Sequence[int], limit_mib: int) -> SampleCaches:
    """Hold clouds, then images of the rows within a limit: a cloud is half an image's size and takes longer to read."""
    chosen = np.asarray(rows, dtype=np.int64)
    scanned = chosen[column_or(source, "valid.lidar", 0.0)[chosen].astype(np.bool_)]
    seen = chosen[column_or(source, "valid.camera", 0.0)[chosen].astype(np.bool_)]
    clouds = RowCache(source.points, scanned.tolist(), limit_mib * _MIB)
    return SampleCaches(clouds, RowCache(source.image, seen.tolist(), limit_mib * _MIB - clouds.nbytes))
