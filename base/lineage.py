"""Hashes that tie an output to what it was made from: input bytes, configuration, code."""

import hashlib
import json
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.plain import plain

_PACKAGES = ("base", "cli", "configs", "datasets", "export", "methods", "pipeline", "sim", "train")
_PIECE_BYTES = 1 << 22


def file_sha256(path: Path, on_bytes: Callable[[int], None] | None = None) -> str:
    """The SHA-256 of a file's bytes in hexadecimal, read in bounded memory.

    Args:
        on_bytes: Called with the number of bytes of each piece read.
    """
    digest = hashlib.sha256()
    try:
        with path.open("rb", buffering=0) as file:
            buffer = bytearray(_PIECE_BYTES)
            view = memoryview(buffer)
            while size := file.readinto(buffer):
                digest.update(view[:size])
                if on_bytes is not None:
                    on_bytes(size)
    except OSError as error:
        raise DatasetsError(
            f"cannot be read ({error.strerror})", where=path, cure="check the path and its permissions"
        ) from error
    return digest.hexdigest()


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
