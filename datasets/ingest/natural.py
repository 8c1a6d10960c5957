"""Finding recordings, in the order in which a person would list them."""

import re
from collections.abc import Sequence
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.config import Merge
from navtool.datasets.recording.opening import recordings_below

SUFFIXES = (".bag", ".mcap", ".db3")


def natural_key(path: Path) -> tuple[tuple[int, int | str], ...]:
    """Sort key by which run-2 comes before run-10."""
    parts = re.split(r"(\d+)", path.as_posix())
    return tuple((0, int(part)) if part.isdigit() else (1, part) for part in parts)


def expand(paths: Sequence[Path], merge: Merge = Merge.file) -> list[Path]:
    """The recordings under the given paths, without repetition, naturally sorted.

    A folder that a ``metadata.yaml`` describes, or that holds the numbered parts of one recording, is that recording;
    any other folder is searched to any depth. A file is
    taken whatever it is called: what is wrong with it is said when it is opened. Where the bags of a folder are merged,
    the folder stands for them.

    Raises:
        DatasetsError: If a path does not exist or a folder holds no recording; all such are named.
    """
    found: dict[Path, Path] = {}
    faults = []
    for path in paths:
        if not path.exists():
            faults.append(f"{path}: no such file or folder")
            continue
        inside = recordings_below(path) if path.is_dir() else [path]
        if merge is Merge.folder and path.is_dir() and inside != [path]:
            inside = [entry.parent for entry in inside]
        if not inside:
            faults.append(f"{path}: holds no recording ({', '.join(SUFFIXES)})")
        found |= {entry.resolve(): entry for entry in inside}
    if faults:
        raise DatasetsError("; ".join(faults), cure="check the paths")
    if not found:
        raise DatasetsError("no recording was named", cure="name bag files or folders")
    return sorted(found.values(), key=natural_key)
