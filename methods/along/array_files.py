"""Results as NumPy arrays in compressed files."""

import zipfile
from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path

import numpy as np

from navtool.methods.along.writers import Outcome, Selection, Writer
from navtool.pipeline.arrays import Array

_EPOCH = (1980, 1, 1, 0, 0, 0)
_LEVEL = 1
"""Level of deflate: maps are mostly zeros, of which higher levels make little less in three times the time."""


class ArrayFiles[R](Writer[R]):
    """Writes each result into a file of its own, ``000000.npz`` on, which ``numpy.load`` opens without pickle."""

    def __init__(
        self, folder: Path, arrays: Callable[[R], Mapping[str, Array]], selection: Selection | None = None
    ) -> None:
        """Make the folder.

        Args:
            folder: Of the files.
            arrays: What a file holds, by name.
            selection: Which results are written.
        """
        super().__init__("arrays", selection)
        self._folder, self._arrays = folder, arrays
        folder.mkdir(parents=True)

    def write(self, outcome: Outcome[R]) -> None:
        """Write a result; the same result gives the same bytes."""
        path = self._folder / f"{outcome.number:06d}.npz"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=_LEVEL) as file:
            for name, content in self._arrays(outcome.result).items():
                buffer = BytesIO()
                np.save(buffer, content, allow_pickle=False)
                entry = zipfile.ZipInfo(f"{name}.npy", _EPOCH)
                entry.compress_type = zipfile.ZIP_DEFLATED
                file.writestr(entry, buffer.getvalue(), compresslevel=_LEVEL)
