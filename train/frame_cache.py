"""Decoded camera images in memory: video is slow to read in random order, and each epoch asks for the same frames."""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from navtool.train.source import NavSource

_MIB = 1024 * 1024


class FrameCache:
    """The images of as many of the given rows as fit, decoded once in row order.

    Loader processes share the memory: the images are one tensor. Which rows are held is a function of the arguments.
    """

    def __init__(self, source: NavSource, rows: Sequence[int], limit_mib: int) -> None:
        wanted = np.unique(np.asarray(rows, dtype=np.int64))
        size = source.image(int(wanted[0])).nbytes if wanted.size and limit_mib else 1
        self._rows = wanted[: limit_mib * _MIB // size]
        frames = [torch.from_numpy(source.image(row)).permute(2, 0, 1) for row in self._rows.tolist()]
        self._images = torch.stack(frames) if frames else torch.empty(0, dtype=torch.uint8)

    def __len__(self) -> int:
        """Number of images held."""
        return len(self._rows)

    def get(self, row: int) -> Tensor | None:
        """The image of a row, [3, h, w] uint8, not to be written to; None where it is not held."""
        slot = int(np.searchsorted(self._rows, row))
        return self._images[slot] if slot < len(self._rows) and self._rows[slot] == row else None
