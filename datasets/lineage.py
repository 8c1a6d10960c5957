"""Hashes that tie an output to what it was made from: input bytes, configuration, code."""

import dataclasses
import hashlib
import json
from collections.abc import Callable, Mapping, Sequence
from enum import Enum
from functools import cache
from importlib.metadata import version
from pathlib import Path

import numpy as np

from navtool.datasets.errors import DatasetsError

_PACKAGES = ("cli", "configs", "datasets", "export", "pipeline", "sim", "train")


_PIECE_BYTES = 1 << 22
_LOGS = ("-journal", "-wal")
"""What SQLite keeps beside a database that was not closed."""


def file_sha256(path: Path, advance: Callable[[int], None] | None = None) -> str:
    """The SHA-256 of a file's bytes in hexadecimal, read in bounded memory.

    Args:
        advance: Called with the number of bytes of each piece read.
    """
    digest = hashlib.sha256()
    try:
        with path.open("rb", buffering=0) as file:
            buffer = bytearray(_PIECE_BYTES)
            view = memoryview(buffer)
            while size := file.readinto(buffer):
                digest.update(view[:size])
                if advance is not None:
                    advance(size)
    except OSError as error:
        raise DatasetsError(
            f"cannot be read ({error.strerror})", where=path, cure="check the path and its permissions"
        ) from error
    return digest.hexdigest()


def recording_sha256(path: Path, advance: Callable[[int], None] | None = None) -> tuple[str, int]:
    """The SHA-256 and the size in bytes of a recording: of the file, or of a folder's files in their names' order.

    A folder's hash covers relative names and contents, so that renaming a part changes it; so does that of a database
    whose recorder left logs beside it.

    Raises:
        DatasetsError: It cannot be read, or vanishes meanwhile.
    """
    try:
        parts = _parts(path)
        if parts == [path]:
            return file_sha256(path, advance), path.stat().st_size
        base, digest, size = (path if path.is_dir() else path.parent), hashlib.sha256(), 0
        for part in parts:
            digest.update(f"{part.relative_to(base).as_posix()}\0{file_sha256(part, advance)}\n".encode())
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


def _parts(path: Path) -> list[Path]:
    """The files of a recording."""
    if path.is_dir():
        return sorted(entry for entry in path.rglob("*") if entry.is_file())
    logs = [log for suffix in _LOGS if (log := path.with_name(path.name + suffix)).is_file() and log.stat().st_size]
    return [path, *logs]


def _gone(path: Path, error: OSError) -> DatasetsError:
    return DatasetsError(f"cannot be read ({error.strerror})", where=path, cure="see whether it is still there")


def plain(value: object) -> object:
    """The value as what JSON knows: dataclasses become objects, enums their names, arrays lists, paths text."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, Mapping):
        return {str(key): plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, Path):
        return value.as_posix()
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [plain(entry) for entry in value]
    return value


def config_hash(config: object) -> str:
    """The SHA-256 of a configuration; equal settings give equal hashes, whatever the order of the keys."""
    text = json.dumps(plain(config), sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


@cache
def code_version() -> str:
    """The package's version with a hash of its own sources, such as ``0.1.0+src.1f2e3d4c5b6a``.

    Two machines with the same sources give the same text, whether installed or run from a checkout.
    """
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for package in _PACKAGES:
        for source in sorted([*(root / package).rglob("*.py"), *(root / package).rglob("*.yaml")]):
            digest.update(f"{source.relative_to(root).as_posix()}\0".encode())
            digest.update(source.read_bytes())
    return f"{version('navtool')}+src.{digest.hexdigest()[:12]}"
