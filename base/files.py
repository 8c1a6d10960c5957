"""Small file operations that are either done or not: never half."""

import json
import os
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from navtool.base.errors import DatasetsError, OutputError


def write_json(path: Path, content: object) -> None:
    """Write JSON so that a reader sees the old file or the new one, and that it survives a crash afterwards.

    Raises:
        OutputError: If it cannot be written (no space, no permission).
    """
    write_bytes(path, (json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n").encode())


def write_bytes(path: Path, content: bytes) -> None:
    """Like ``write_json``, for bytes."""
    temporary = path.with_name(f".{path.name}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:
        temporary.unlink(missing_ok=True)
        cure = "check the disk's space and the folder's rights"
        raise OutputError(f"cannot be written ({error.strerror})", where=path, cure=cure) from error


def parquet_bytes(table: pa.Table) -> bytes:
    """A small table as a Parquet file."""
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    content: bytes = sink.getvalue().to_pybytes()
    return content


def read_json(path: Path, cure: str) -> dict[str, object]:
    """The JSON object in a file.

    Raises:
        DatasetsError: If the file is missing or holds no JSON object, with this cure.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise DatasetsError(f"cannot be read ({error.strerror})", where=path, cure=cure) from error
    except ValueError as error:
        raise DatasetsError(f"is not JSON ({error})", where=path, cure=cure) from error
    if not isinstance(content, dict):
        raise DatasetsError("holds no JSON object", where=path, cure=cure)
    return content


def move(source: Path, target: Path) -> None:
    """Move a finished file or folder into its place, durably; an older file there is replaced."""
    target.parent.mkdir(parents=True, exist_ok=True)
    source.replace(target)
    descriptor = os.open(target.parent, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
