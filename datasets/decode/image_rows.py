"""Where the rows of a raw image lie in its bytes, whatever its step says."""

from typing import NamedTuple

from navtool.base.errors import DatasetsError
from navtool.base.note import Note

MISFIT = "image.size-misfit"
"""The code of what is said of numbers that the bytes contradict."""

_BLOCK_ROWS, _MOST_MORE_ROWS = 16, 64


class Rows(NamedTuple):
    """Rows of an image in its bytes."""

    width: int
    height: int
    step: int
    notes: tuple[Note, ...] = ()
    luma_rows: int = 0
    """Rows from the first one of luma to the first one of chroma; 0 where they are those of the image."""


def rows_of(
    width: int, height: int, step: int, data_bytes: int, pixel_bytes: int, planes: float, encoding: str
) -> Rows:
    """The rows that fit the bytes, with a note where they are not what the message says.

    Args:
        step: As recorded, in bytes.
        pixel_bytes: Bytes of a pixel in a row of its first plane.
        planes: Rows of all planes together for each row of the image.

    Raises:
        DatasetsError: There are no pixels, or fewer bytes than the size needs.
    """
    if width == 0 or height == 0:
        raise DatasetsError(f"an image of {width} x {height} pixels")
    row, rows = width * pixel_bytes, int(height * planes)
    # The padding behind the last row may be left out.
    if step >= row and step * (rows - 1) + row <= data_bytes:
        aligned = _aligned_rows(height, step, data_bytes, planes)
        told = (_note(f"{aligned - height} rows of padding lie behind those of luma: they are left out"),)
        return Rows(width, height, step, told, aligned) if aligned else Rows(width, height, step)
    if step == height * pixel_bytes and step * int(width * planes) == data_bytes:
        return Rows(
            height, width, step, (_note("width and height are exchanged: step and bytes are those of the other"),)
        )
    if row * rows > data_bytes:
        needed = max(step, row) * (rows - 1) + row
        raise DatasetsError(f"truncated image: {data_bytes} bytes of pixels, but its size needs {needed}")
    padded = data_bytes // rows
    if data_bytes % rows == 0 and (data_bytes - row * rows) % row:
        return Rows(width, height, padded, (_note("step is not that of its rows, by which they fill the bytes"),))
    what = f"step is not the size of a row of {encoding} pixels: rows lie one behind the other"
    return Rows(width, height, row, (_note(what),))


def step_that_fills(rows: int, step: int, data_bytes: int) -> int:
    """The longer step by which so many rows fill bytes of which the stated one leaves some; 0 where there is none."""
    return data_bytes // rows if data_bytes % rows == 0 and data_bytes > step * rows else 0


def _aligned_rows(height: int, step: int, data_bytes: int, planes: float) -> int:
    """The height that video hardware gave the planes, a multiple of 16, where it fills the bytes; 0 where none does."""
    rows = data_bytes / (step * planes)
    more = rows - height
    return int(rows) if 1.0 < planes <= 2.0 and rows % _BLOCK_ROWS == 0 and 0 < more < _MOST_MORE_ROWS else 0


def _note(what: str) -> Note:
    return Note(MISFIT, what)
