"""Which files make up a recording."""

import re
from pathlib import Path, PurePath
from typing import Any

import yaml

from navtool.datasets.errors import DatasetsError
from navtool.datasets.recording.foreign import translated

_SUFFIXES = (".bag", ".db3", ".mcap")


def files_of(path: Path) -> list[Path]:
    """The files of the recording at a path, in the order they were recorded.

    A folder is the recording that its ``metadata.yaml`` describes; without one, as a killed recorder leaves it, the one
    bag file in it or the numbered parts of one.

    Raises:
        DatasetsError: There is nothing, no recording in the folder, or more than one, or a file is missing.
    """
    if not path.exists():
        raise DatasetsError("there is no such file or folder", where=path, cure="check the path")
    if not path.is_dir():
        return [path]
    if (path / "metadata.yaml").is_file():
        return _described(path)
    with translated("the folder cannot be listed", where=path):
        found = sorted(x for x in path.iterdir() if x.suffix in _SUFFIXES and x.is_file())
    if not found:
        raise DatasetsError(
            "there is no recording in this folder", where=path, cure="pass a folder with a metadata.yaml, or a bag file"
        )
    parts = [re.fullmatch(r"(.*)_(\d+)", x.stem) for x in found]
    stems = {(part[1], file.suffix) if part else None for part, file in zip(parts, found, strict=True)}
    if len(found) > 1 and (len(stems) > 1 or None in stems):
        raise DatasetsError(
            f"there are several recordings in this folder: {', '.join(x.name for x in found)}",
            where=path,
            cure="pass one of them",
        )
    return sorted(found, key=lambda x: (len(x.name), x.name))


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
