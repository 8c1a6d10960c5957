"""Which files make up a recording."""

import re
from pathlib import Path, PurePath
from typing import Any

import yaml

from navtool.base.errors import DatasetsError
from navtool.datasets.recording.foreign import translated

_BAG_FILE = re.compile(r"(?P<stem>.*?)(_(?P<part>\d+))?(?P<suffix>\.(bag|db3|mcap)(\.zstd)?)")
_NAMED = 10
"""Recordings that an error names before it counts the rest."""


def files_of(path: Path) -> list[Path]:
    """The files of the recording at a path, in the order they were recorded.

    A folder is the recording that its ``metadata.yaml`` describes; without one, as a killed recorder leaves it, the one
    bag file in it or the numbered parts of one.

    Raises:
        DatasetsError: There is nothing, no recording in the folder, or more than one, or a file is missing.
    """
    with translated("the path cannot be read", where=path):
        if path.is_file():
            return [path]
        if path.is_dir():
            return _described(path) if (path / "metadata.yaml").is_file() else _found(path)
        if path.exists():
            raise DatasetsError("this is neither a file nor a folder", cure="pass a bag file")
        raise DatasetsError("there is no such file or folder", cure="check the path")


def all_files_of(folder: Path) -> list[Path]:
    """The files of all recordings that lie in a folder, whatever their formats, in the order of their names.

    Raises:
        DatasetsError: There are none.
    """
    with translated("the folder cannot be read", where=folder):
        found: list[Path] = []
        for entry in sorted(folder.iterdir()):
            if entry.is_file() and _BAG_FILE.fullmatch(entry.name):
                found.append(entry)
            elif (entry / "metadata.yaml").is_file():
                found += files_of(entry)
    if not found:
        raise DatasetsError("there is no recording in this folder", where=folder, cure="pass a folder with bag files")
    return found


def recordings_in(folder: Path) -> list[Path]:
    """The recordings in a folder, to any depth: bag files, and folders that a ``metadata.yaml`` describes.

    Raises:
        DatasetsError: A folder cannot be read.
    """
    found = []
    with translated("the folder cannot be read", where=folder, cure="check its rights"):
        if (folder / "metadata.yaml").is_file():
            return [folder]
        for entry in sorted(folder.iterdir()):
            if entry.is_dir():
                found += recordings_in(entry)
            elif _BAG_FILE.fullmatch(entry.name):
                found.append(entry)
    return found


def _several(folder: Path, found: list[Path]) -> DatasetsError:
    named = ", ".join(str(path.relative_to(folder)) for path in found[:_NAMED])
    more = f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""
    what = f"this folder holds {len(found)} recordings, not one: {named}{more}"
    return DatasetsError(what, cure="pass one of them; `navtool ingest` takes all of a folder")


def _found(folder: Path) -> list[Path]:
    matches = [(x, match) for x in sorted(folder.iterdir()) if (match := _BAG_FILE.fullmatch(x.name)) and x.is_file()]
    if not matches:
        below = recordings_in(folder)
        if len(below) > 1:
            raise _several(folder, below)
        if below:
            raise DatasetsError("the recording is not in this folder itself", cure=f"pass {below[0]}")
        raise DatasetsError("there is no recording in this folder", cure="pass a bag file, or a folder with bag files")
    parts_of_one = len({(match["stem"], match["suffix"]) for _, match in matches}) == 1
    if len(matches) > 1 and not (parts_of_one and all(match["part"] for _, match in matches)):
        raise _several(folder, recordings_in(folder))
    return [x for x, _ in sorted(matches, key=lambda pair: int(pair[1]["part"] or 0))]


def _described(folder: Path) -> list[Path]:
    file = folder / "metadata.yaml"
    with translated("the description of the recording cannot be read", where=file):
        # Parts are named relative to the folder, by old recorders with the folder's name before.
        content: Any = yaml.safe_load(file.read_text())
        names = [PurePath(str(x)).name for x in content["rosbag2_bagfile_information"]["relative_file_paths"]]
    if not names:
        raise DatasetsError("it lists no files", where=file, cure="pass a bag file of the folder")
    if missing := [name for name in names if not (folder / name).is_file()]:
        raise DatasetsError(
            f"{len(missing)} of the {len(names)} files it lists are missing: {', '.join(missing)}",
            where=file,
            cure="copy the whole recording, or pass one of its files",
        )
    return [folder / name for name in names]
