"""Where the rows of a raw image lie in its bytes, whatever its step says."""

from typing import NamedTuple

from navtool.base.errors import DatasetsError
from navtool.base.note import Note

MISFIT = "image.size-misfit"
"""The code of what is said of numbers that the bytes contradict."""


class Rows(NamedTuple):
    """Rows of an image in its bytes."""

    width: int
    height: int
    step: int
    notes: tuple[Note, ...] = ()


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
        return Rows(width, height, step)
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


def _note(what: str) -> Note:
    return Note(MISFIT, what)
