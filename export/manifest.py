"""The manifest of an artefact: what goes in and out, what it was made from, and the hash of every file."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path, PurePath
from typing import Any

from navtool.base.from_plain import from_plain
from navtool.base.plain import plain_fields
from navtool.base.setting_error import SettingError
from navtool.export.errors import ExportError
from navtool.train.contract import TensorSpec

MANIFEST = "manifest.json"
MANIFEST_SCHEMA = 1
"""Raised whenever a field changes its meaning; other versions are refused."""
MAX_MANIFEST_BYTES = 16 * 1024 * 1024
"""A manifest that is larger is not one of ours."""


@dataclass(frozen=True, slots=True)
class FileEntry:
    """A file of the artefact as it must be."""

    sha256: str
    size: int
    """Bytes."""


@dataclass(frozen=True, slots=True)
class Manifest:
    """The content of ``manifest.json``."""

    kind: str
    """Name of its kind of model, such as in ``navtool.train.models``."""
    created_by: str
    """Version of the code that exported it."""
    inputs: tuple[TensorSpec, ...]
    """Arguments of the model's forward, in order."""
    outputs: tuple[TensorSpec, ...]
    """What it returns."""
    methods: tuple[str, ...]
    """What the model offers, forward included."""
    golden_source: str
    """Where the golden inputs come from."""
    golden_tolerance: float
    """Largest absolute difference from the golden output."""
    config: Mapping[str, Any]
    """The run's configuration."""
    lineage: Mapping[str, Any]
    """Recordings with their hashes, configuration hash, code version, split."""
    metrics: Mapping[str, Any] | None
    """The run's figures; None where it did not finish."""
    files: Mapping[str, FileEntry]
    """Every file but the manifest, by name."""

    def __post_init__(self) -> None:
        if not self.golden_tolerance >= 0.0:
            raise ValueError(f"golden_tolerance = {self.golden_tolerance} must not be negative")
        for name in self.files:
            if name in ("", ".", "..", MANIFEST) or PurePath(name).name != name or "\\" in name or "\0" in name:
                raise ValueError(f"file name {name!r} is not a plain name inside the artefact")

    def to_json(self) -> dict[str, Any]:
        """The manifest as JSON, with a digest of all its other fields."""
        body = {"schema_version": MANIFEST_SCHEMA} | plain_fields(self)
        return body | {"digest": digest(body)}


def digest(content: Mapping[str, Any]) -> str:
    """The SHA-256 over all fields but ``digest``.

    It finds damage and careless edits. It does not prove who wrote the manifest: whoever changes a field on purpose can
    recompute it, so that trust in an artefact comes from where it was fetched.
    """
    body = {key: value for key, value in content.items() if key != "digest"}
    text = json.dumps(body, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def read_manifest(artefact: Path) -> Manifest:
    """The manifest of an artefact folder, checked field by field.

    Raises:
        ExportError: There is no artefact, or its manifest is damaged, was edited, or has another schema version.
    """
    path = artefact / MANIFEST
    content = _read(artefact, path)
    version = content.get("schema_version")
    if version != MANIFEST_SCHEMA:
        raise ExportError(
            f"schema version {version!r}; this navtool reads {MANIFEST_SCHEMA}",
            where=path,
            cure="export the run again, or use the navtool that wrote it",
        )
    if content.get("digest") != digest(content):
        raise _damaged(path, "its digest does not match: a field was changed after the export")
    known = {entry.name for entry in fields(Manifest)}
    try:
        return from_plain(Manifest, {name: content[name] for name in content if name in known}, where=path)
    except SettingError as error:
        raise _damaged(path, error.what) from error


def _read(artefact: Path, path: Path) -> dict[str, Any]:
    if not artefact.is_dir():
        raise ExportError("no such folder", where=artefact, cure="name the folder that `navtool export --out` wrote")
    if path.is_symlink() or not path.is_file():
        raise ExportError("is not an artefact: it has no manifest.json", where=artefact, cure="export a run")
    try:
        if path.stat().st_size > MAX_MANIFEST_BYTES:
            raise _damaged(path, f"it has {path.stat().st_size} bytes")
        content = json.loads(path.read_text(encoding="utf-8"), parse_constant=_no_constant)
    except (OSError, ValueError, RecursionError) as error:
        raise _damaged(path, str(error).split("\n", maxsplit=1)[0][:200]) from error
    if not isinstance(content, dict):
        raise _damaged(path, "it holds no JSON object")
    return content


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is not JSON")


def _damaged(path: Path, what: str) -> ExportError:
    return ExportError(f"is damaged ({what})", where=path, cure="export the run again, or fetch the artefact again")
