"""What a command line names: paths apart from overrides, and refused where they cannot be meant."""

import re
from collections.abc import Sequence
from pathlib import Path

from navtool.cli.compose import UsageError

_OVERRIDE = re.compile(r"^[+~]{0,2}[A-Za-z_][\w./@:-]*=")


def split_overrides(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Paths and ``key=value`` overrides; a file that exists is a path whatever its name."""
    paths = [argument for argument in arguments if Path(argument).exists() or not _OVERRIDE.match(argument)]
    return paths, [argument for argument in arguments if argument not in paths]


def require_there(*paths: Path | None) -> None:
    """Refuse inputs that are not there, before any work is done; None is an option that was not given.

    Raises:
        UsageError: One of them names nothing.
    """
    for path in paths:
        if path is not None and not path.exists():
            raise UsageError("there is no such file or folder", where=path, cure="check the path")


def require_folder_for(*files: Path | None) -> None:
    """Refuse output files that could not be written where they are named, before any work is done for them.

    Raises:
        UsageError: One of them is a folder, or lies in a folder that is not there: none is made for it.
    """
    for file in files:
        if file is not None and file.is_dir():
            raise UsageError("is a folder", where=file, cure="name a file in it")
        if file is not None and not file.parent.is_dir():
            raise UsageError("there is no such folder", where=file.parent, cure="make it, or name another")


def local_path(text: str) -> Path:
    """Where an input lies; one that lies elsewhere is fetched, as for ingest.

    Raises:
        UsageError: There is no such file or folder.
        DatasetsError: A URL cannot be reached or holds no recording.
    """
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.recording.remote import default_cache, is_url, local_paths

    if not is_url(text):
        require_there(Path(text))
        return Path(text)
    with WorkProgress("files fetched") as progress:
        (path,) = local_paths([text], default_cache(), progress)
    return path
