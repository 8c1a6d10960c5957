"""How the points of a PointCloud2 lie in its bytes, where its numbers contradict each other.

Width, height, point_step, row_step and the number of bytes say the same thing several times, and drivers fill some of
them wrong. None is believed alone: what fits the bytes counts.
"""

from typing import NamedTuple

from navtool.base.errors import DatasetsError
from navtool.base.note import Note

MISFIT = "cloud.size-misfit"
"""The code of what is said of numbers that the bytes contradict."""

_MOST_PADDING = 64
"""Bytes by which rows are padded, and no more."""


class Said(NamedTuple):
    """What a message says of its size, as recorded."""

    width: int
    height: int
    point_step: int
    row_step: int
    data_bytes: int
    fields_end: int
    """The first byte behind the fields of a point that are used."""
    last_field: str
    """The name of the one that ends there."""


class Layout(NamedTuple):
    """Where points lie, in an order that fits the bytes."""

    width: int
    height: int
    point_step: int
    row_step: int
    notes: tuple[Note, ...]


def layout_of(said: Said) -> Layout:
    """The points that fit the bytes, with a note where they are not what the message says.

    Raises:
        DatasetsError: Nothing that the message says fits its bytes.
    """
    step, notes = _point_step(said)
    if said.width * said.height == 0:
        return _unsaid(said, step, notes)
    row = said.width * step
    rows = said.row_step if said.height > 1 else row
    if said.height == 1 and said.data_bytes == said.row_step > row and said.data_bytes % step == 0:
        points = said.data_bytes // step
        return Layout(points, 1, step, points * step, (*notes, _points(said, points)))
    if rows >= row and rows * (said.height - 1) + row <= said.data_bytes:
        return Layout(said.width, said.height, step, rows, notes)
    if row * said.height <= said.data_bytes:
        padded = said.data_bytes // said.height if said.data_bytes % said.height == 0 else row
        rows, lie = padded, f"rows of {padded} fill the bytes" if padded > row else "rows lie one behind the other"
        wrong = _note(f"row_step is {said.row_step} bytes, not that of a row of points; {lie}")
        return Layout(said.width, said.height, step, rows, (*notes, wrong))
    if said.data_bytes % step or not said.data_bytes:
        needed = max(rows, row) * (said.height - 1) + row
        raise DatasetsError(f"truncated point cloud: {said.data_bytes} bytes, but its size needs {needed}")
    points = said.data_bytes // step
    return Layout(points, 1, step, points * step, (*notes, _points(said, points)))


def _point_step(said: Said) -> tuple[int, tuple[Note, ...]]:
    """The bytes of a point: as the message says, or as many as its size leaves for one where fields do not fit in."""
    step, points = said.point_step, said.width * said.height
    fits = step >= said.fields_end > 0
    shared = said.data_bytes // points if points and said.data_bytes % points == 0 else 0
    short = points * step > said.data_bytes and said.data_bytes % step if fits else True
    if not short and not _is_outvoted(said, shared):
        return step, ()
    if shared >= said.fields_end and shared != step:
        return shared, (_note(f"point_step is not the size of a point, by which its {points} points fill the bytes"),)
    if not fits:
        raise DatasetsError(
            f"field {said.last_field} ends at byte {said.fields_end} of a point, but point_step is {step}"
        )
    return step, ()


def _is_outvoted(said: Said, shared: int) -> bool:
    """Whether width, height, row_step and the bytes agree on another size of a point, and no padding looks like that.

    Rows are padded to a multiple of 64 bytes at most by what makes recordings, and not by some for each point.
    """
    if not shared or said.row_step != said.width * shared:
        return False
    padding = said.width * (shared - said.point_step)
    return padding < 0 or (said.height > 1 and padding >= _MOST_PADDING and (shared - said.point_step) % 4 == 0)


def _unsaid(said: Said, step: int, notes: tuple[Note, ...]) -> Layout:
    """The points of a cloud that has a width or a height of 0: none, unless its bytes are a whole number of them."""
    points = 0 if said.data_bytes % step else said.data_bytes // step
    return Layout(points, 1, step, points * step, (*notes, _points(said, points)) if points else notes)


def _points(said: Said, points: int) -> Note:
    less = "fewer" if points < said.width * said.height else "more"
    return _note(f"its bytes hold {less} points than width x height says; all of them are read")


def _note(what: str) -> Note:
    return Note(MISFIT, what)
