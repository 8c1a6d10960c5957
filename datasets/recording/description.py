"""What a ``metadata.yaml`` says of the recording beside it, as far as it can be believed."""

from collections.abc import Sequence
from pathlib import Path, PurePath
from typing import Any, NamedTuple

import yaml

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.recording.foreign import describe
from navtool.datasets.recording.part_names import (
    Chosen,
    bare_name,
    is_bag_file,
    number_of,
    pattern_of,
    without_copies,
)

DESCRIPTION = "recording.description"
"""Code of the notes that say what a metadata.yaml is not."""

NAME = "metadata.yaml"


class Described(NamedTuple):
    """The files of a recording that is described, and what its description lacks or has too much."""

    files: list[Path]
    """Empty where nothing that it lists is there."""
    notes: tuple[Note, ...]
    missing: tuple[str, ...] = ()


def described(folder: Path) -> Described | None:
    """What the description in a folder amounts to; None where there is none.

    Raises:
        DatasetsError: It cannot be read (rights, a broken disk).
    """
    file = folder / NAME
    if not file.is_file():
        return None
    try:
        content: Any = yaml.safe_load(file.read_text(encoding="utf-8"))
        listed = _names(content["rosbag2_bagfile_information"]["relative_file_paths"])
    except OSError as error:
        raise DatasetsError(f"the description cannot be read ({error.strerror})", where=file) from error
    except (yaml.YAMLError, ValueError, KeyError, TypeError, RecursionError) as error:
        what = "is empty" if not file.stat().st_size else f"describes no recording ({describe(error)})"
        return Described([], (_note(f"metadata.yaml {what}: the files beside it are read"),))
    if not listed:
        return Described([], (_note("metadata.yaml lists no files: those beside it are read"),))
    return _compared(folder, listed)


def _names(paths: Any) -> list[str]:
    if not isinstance(paths, list | None):
        raise TypeError("its relative_file_paths are no list")
    return [PurePath(str(path)).name for path in paths or ()]


def _compared(folder: Path, listed: Sequence[str]) -> Described:
    there = without_copies(entry for entry in folder.iterdir() if is_bag_file(entry))
    by_name = {bare_name(chosen.file): chosen for chosen in there}
    names = list(dict.fromkeys(name.removesuffix(".zstd") for name in listed))
    found = [by_name[name] for name in names if name in by_name]
    missing = tuple(name for name in names if name not in by_name and not (folder / name).is_file())
    found += [Chosen(folder / name) for name in names if name not in by_name and (folder / name).is_file()]
    if not found:
        return Described([], (), missing)
    notes = [note for chosen in found for note in chosen.notes]
    packed = [chosen.file.name for chosen in found if chosen.file.name not in listed and not chosen.notes]
    if packed:
        notes.append(_note(f"metadata.yaml has {', '.join(packed)} packed another way: it is read as it is"))
    if missing:
        notes.append(_note(f"metadata.yaml lists {', '.join(missing)}, which is not there: the rest is read"))
    patterns = {pattern for chosen in found if (pattern := pattern_of(chosen.file)) is not None}
    unlisted = [chosen for name, chosen in by_name.items() if name not in names]
    parts = [chosen for chosen in unlisted if pattern_of(chosen.file) in patterns]
    if parts:
        notes.append(_note(f"metadata.yaml does not list {_named(parts)}, which is read all the same"))
        notes += [note for chosen in parts for note in chosen.notes]
    if others := [chosen for chosen in unlisted if chosen not in parts]:
        notes.append(
            _note(f"metadata.yaml does not list {_named(others)}, which is not read: it is no part by its name")
        )
    files = [chosen.file for chosen in (*found, *parts)]
    return Described(sorted(files, key=number_of) if parts else files, tuple(notes), missing)


def _named(chosen: Sequence[Chosen]) -> str:
    return ", ".join(entry.file.name for entry in chosen)


def _note(what: str) -> Note:
    return Note(DESCRIPTION, what)
