"""What identifies a recording: its bytes, its state, its name."""

import hashlib
import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.lineage import file_sha256
from navtool.datasets.recording.folder import parts_named

_LOGS = ("-journal", "-wal")
"""What SQLite keeps beside a database that was not closed."""


def recording_sha256(path: Path, on_hashed: Callable[[int], None] | None = None) -> tuple[str, int]:
    """The SHA-256 and the size in bytes of a recording: of the file, or of a folder's files in their names' order.

    A folder's hash covers relative names and contents, so that renaming a part changes it; so does that of a database
    whose recorder left logs beside it.

    Raises:
        DatasetsError: It cannot be read, or vanishes meanwhile.
    """
    try:
        parts = _parts(path)
        if parts == [path]:
            return file_sha256(path, on_hashed), path.stat().st_size
        base, digest, size = (path if path.is_dir() else path.parent), hashlib.sha256(), 0
        for part in parts:
            digest.update(f"{part.relative_to(base).as_posix()}\0{file_sha256(part, on_hashed)}\n".encode())
            size += part.stat().st_size
    except OSError as error:
        raise _gone(path, error) from error
    return digest.hexdigest(), size


def recording_state(path: Path) -> tuple[tuple[str, int, int], ...]:
    """Name, size and time of change of a recording's files: the same as long as nobody writes to it.

    Raises:
        DatasetsError: It cannot be read, or vanishes meanwhile.
    """
    try:
        found = [(part.as_posix(), part.stat()) for part in _parts(path)]
    except OSError as error:
        raise _gone(path, error) from error
    return tuple((name, state.st_size, state.st_mtime_ns) for name, state in found)


def size_of(path: Path) -> int:
    """Bytes of a recording, a file or a folder; what vanishes meanwhile counts nothing."""
    size = 0
    parts = [chosen.file for chosen in parts_named(path)]
    for file in [path] if path.is_file() else parts or path.rglob("*"):
        with suppress(OSError):
            size += file.stat().st_size if file.is_file() else 0
    return size


def _parts(path: Path) -> list[Path]:
    """The files of a recording."""
    if path.is_dir():
        return sorted(entry for entry in path.rglob("*") if entry.is_file())
    if parts := parts_named(path):
        return sorted(chosen.file for chosen in parts)
    logs = [log for suffix in _LOGS if (log := path.with_name(path.name + suffix)).is_file() and log.stat().st_size]
    return [path, *logs]


def _gone(path: Path, error: OSError) -> DatasetsError:
    return DatasetsError(f"cannot be read ({error.strerror})", where=path, cure="see whether it is still there")


def source_name(path: Path) -> str:
    """How a recording is named in the data set: its folder's name and its own."""
    named = absolute(path)
    return f"{named.parent.name}/{named.name}"


def absolute(path: Path) -> Path:
    """The whole path, by the names that it was given with: a link is not followed."""
    return Path(os.path.abspath(path))  # noqa: PTH100 - Path.absolute keeps the dots
