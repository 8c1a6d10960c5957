"""A file as if it were bytes, read where it is asked for."""

import os
from pathlib import Path

_PIECE = 1 << 22


class FileBytes:
    """The bytes of a file, by slices and searches.

    Not a memory map: one of those ends the whole process when the file shrinks meanwhile.
    """

    def __init__(self, path: Path) -> None:
        """Open it.

        Raises:
            OSError: It cannot be opened.
        """
        self._file = os.open(path, os.O_RDONLY)
        self._size = os.fstat(self._file).st_size

    def __len__(self) -> int:
        """Its size when it was opened."""
        return self._size

    def __getitem__(self, part: slice) -> bytes:
        """The bytes of a slice; fewer where the file ends before."""
        first, end, step = part.indices(self._size)
        if step != 1:
            raise ValueError("only slices of step 1")
        pieces = []
        while first < end:
            piece = os.pread(self._file, end - first, first)
            if not piece:
                break
            pieces.append(piece)
            first += len(piece)
        return pieces[0] if len(pieces) == 1 else b"".join(pieces)

    def find(self, what: bytes, offset: int) -> int:
        """Where the bytes occur first at or after an offset; -1 for nowhere."""
        while offset < self._size:
            piece = self[offset : offset + _PIECE + len(what) - 1]
            found = piece.find(what)
            if found != -1:
                return offset + found
            offset += _PIECE
        return -1

    def close(self) -> None:
        """Let go of the file."""
        if self._file != -1:
            os.close(self._file)
            self._file = -1
