"""Which files make up a recording: the same for everything that opens, lists or hashes one."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.recording.description import DESCRIPTION, Described, described
from navtool.datasets.recording.foreign import translated
from navtool.datasets.recording.part_names import (
    Chosen,
    consecutive,
    is_bag_file,
    number_of,
    pattern_of,
    without_copies,
)

_NAMED = 10
"""Recordings that an error names before it counts the rest."""
_PART_GAP_NS = 5_000_000_000
"""The parts of one recording follow each other within this time of record; what is further apart are runs."""

type SpanOf = Callable[[Path], tuple[int, int] | None]
"""First and last time of record of a file; None where they are not known without unpacking or repairing it."""


class FileSet(NamedTuple):
    """The files of one recording in the order they were recorded, and what is odd about them."""

    files: list[Path]
    notes: tuple[Note, ...] = ()


def files_of(path: Path, span_of: SpanOf) -> FileSet:
    """The files of the recording at a path.

    A folder is the recording that its ``metadata.yaml`` describes; without one, or with one that describes nothing that
    is there, the one bag file in it or the numbered parts of one. A path such as ``run_*.db3`` stands for the parts of
    one of several recordings in a folder.

    Raises:
        DatasetsError: There is nothing, no recording in the folder, or more than one, or all files are missing.
    """
    with translated("the path cannot be read", where=path):
        if path.is_file():
            return FileSet([path])
        if path.is_dir():
            return _of_folder(path, span_of)
        if path.exists():
            raise DatasetsError("this is neither a file nor a folder", cure="pass a bag file")
        parts = parts_named(path)
        if parts:
            return _joined(parts)
        raise DatasetsError("there is no such file or folder", cure="check the path")


def all_files_of(folder: Path, span_of: SpanOf) -> FileSet:
    """The files of all recordings that lie in a folder, whatever their formats, in the order of their names.

    Raises:
        DatasetsError: There are none.
    """
    with translated("the folder cannot be read", where=folder):
        here = {chosen.file: chosen for chosen in without_copies(x for x in folder.iterdir() if is_bag_file(x))}
        found: list[Chosen] = []
        for entry in sorted(folder.iterdir()):
            if entry in here:
                found.append(here[entry])
            elif entry.is_dir() and recordings_in(entry, span_of) == [entry]:
                found += map(Chosen, _of_folder(entry, span_of).files)
    if not found:
        raise DatasetsError("there is no recording in this folder", where=folder, cure="pass a folder with bag files")
    return _joined(found)


def recordings_in(folder: Path, span_of: SpanOf) -> list[Path]:
    """The recordings in a folder, to any depth, each by the path that opens it.

    Bag files; folders that a ``metadata.yaml`` describes, or that hold the numbered parts of one recording; and where a
    folder holds the parts of several, or other recordings too, what they are called alike: ``run_*.db3``.

    Raises:
        DatasetsError: A folder cannot be read.
    """
    with translated("the folder cannot be read", where=folder, cure="check its rights"):
        found = described(folder)
        if found is not None and found.files:
            return [folder]
        below = [path for entry in sorted(folder.iterdir()) if entry.is_dir() for path in recordings_in(entry, span_of)]
        sets = _sets(folder, span_of)
        if len(sets) == 1 and not below and (len(sets[0]) > 1 or found is not None):
            return [folder]
        # A description whose files are gone is a recording that cannot be read, and not what lies in the folders below.
        gone = [folder] if found is not None and found.missing and not sets else []
        return sorted([*gone, *map(_name_of, sets), *below], key=str)


def parts_named(path: Path) -> list[Chosen]:
    """The parts that a path such as ``run_*.db3`` stands for; none where it is another path."""
    if "*" not in path.name or not path.parent.is_dir():
        return []
    parts = without_copies(x for x in path.parent.iterdir() if is_bag_file(x) and pattern_of(x) == path.name)
    return sorted(parts, key=lambda chosen: number_of(chosen.file))


def _name_of(parts: Sequence[Chosen]) -> Path:
    first = parts[0].file
    return first if len(parts) == 1 else first.with_name(pattern_of(first) or first.name)


def _of_folder(folder: Path, span_of: SpanOf) -> FileSet:
    found = described(folder)
    if found is not None and found.files:
        return FileSet(found.files, found.notes)
    sets = _sets(folder, span_of)
    if found is not None and found.missing and not sets:
        raise _all_missing(folder, found)
    if len(sets) != 1:
        raise _none_or_several(folder, span_of)
    parts = sets[0]
    notes = [] if found is None else [*found.notes, *_outdated(found)]
    if len(parts) > 1:
        named = ", ".join(chosen.file.name for chosen in parts)
        notes.append(Note("recording.parts", f"{len(parts)} numbered files are read as the parts of one: {named}"))
    return _joined(parts, notes)


def _outdated(found: Described) -> list[Note]:
    if not found.missing:
        return []
    what = f"metadata.yaml lists {', '.join(found.missing)}, which is not there: the files beside it are read"
    return [Note(DESCRIPTION, what)]


def _all_missing(folder: Path, found: Described) -> DatasetsError:
    return DatasetsError(
        f"{len(found.missing)} of the {len(found.missing)} files it lists are missing: {', '.join(found.missing)}",
        where=folder / "metadata.yaml",
        cure="copy the whole recording, or pass one of its files",
    )


def _sets(folder: Path, span_of: SpanOf) -> list[list[Chosen]]:
    """The bag files in a folder itself, those that are parts of one recording together."""
    groups: dict[str, list[Chosen]] = {}
    for chosen in without_copies(entry for entry in folder.iterdir() if is_bag_file(entry)):
        groups.setdefault(pattern_of(chosen.file) or chosen.file.name, []).append(chosen)
    sets: list[list[Chosen]] = []
    for group in groups.values():
        parts = sorted(group, key=lambda chosen: number_of(chosen.file))
        together = len(parts) == 1 or _follow([chosen.file for chosen in parts], span_of)
        sets += [parts] if together else [[chosen] for chosen in parts]
    return sets


def _follow(parts: Sequence[Path], span_of: SpanOf) -> bool:
    """Whether numbered files are parts of one recording: what is not known of a file does not tell them apart."""
    if not consecutive(parts):
        return False
    spans = [span for part in parts if (span := span_of(part)) is not None]
    return all(before[0] <= after[0] and after[0] - before[1] <= _PART_GAP_NS for before, after in pairwise(spans))


def _joined(parts: Sequence[Chosen], more: Sequence[Note] = ()) -> FileSet:
    return FileSet([chosen.file for chosen in parts], (*more, *(note for chosen in parts for note in chosen.notes)))


def _none_or_several(folder: Path, span_of: SpanOf) -> DatasetsError:
    found = recordings_in(folder, span_of)
    if not found:
        cure = "pass a bag file, or a folder with bag files"
        return DatasetsError("there is no recording in this folder", cure=cure)
    if len(found) == 1:
        return DatasetsError("the recording is not in this folder itself", cure=f"pass {found[0]}")
    named = ", ".join(str(path.relative_to(folder)) for path in found[:_NAMED])
    more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    what = f"this folder holds {len(found)} recordings, not one: {named}{more}"
    return DatasetsError(what, cure="pass one of them; `navtool ingest` takes all of a folder")
