"""What notes say, by their codes."""

from collections.abc import Iterable

from navtool.base.note import Note


def noted(notes: Iterable[Note], code: str) -> list[str]:
    """The texts of the notes of a code."""
    return [note.text for note in notes if note.code == code]
