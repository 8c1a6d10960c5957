"""The error of a recording that is written to while it is read."""

from pathlib import Path

from navtool.base.errors import DatasetsError


def changed_meanwhile(path: Path) -> DatasetsError:
    """What is said of a recording that is not the same at two moments of reading it."""
    cure = "run the command again once its recorder is done"
    return DatasetsError("the recording changed while it was read", where=path, cure=cure)
