"""Opening an artefact: every byte is checked against the manifest before anything in it is used."""

import hashlib
from dataclasses import dataclass
from pathlib import Path

import torch

from navtool.export.errors import ExportError
from navtool.export.golden import GOLDEN
from navtool.export.manifest import MANIFEST, Manifest, read_manifest
from navtool.export.scripted import SCRIPT_ERRORS, Scripted, load_scripted, told_by_script
from navtool.train.models import unknown_model

MODEL = "model.ts"
_CURE = "export the run again, or fetch the artefact again"


@dataclass(frozen=True, slots=True)
class Artefact:
    """An artefact whose files are those of its manifest."""

    path: Path
    manifest: Manifest
    content: dict[str, bytes]
    """The checked bytes of each file: what was hashed is what is used."""

    def load(self, device: torch.device) -> Scripted:
        """The network.

        Raises:
            ExportError: The file is as it was exported, but cannot be loaded here.
        """
        try:
            return load_scripted(self.content[MODEL], device)
        except (*SCRIPT_ERRORS, ValueError, KeyError) as error:
            what = f"cannot be loaded ({told_by_script(error)})"
            raise ExportError(what, where=self.path / MODEL, cure=_CURE) from error


def open_artefact(path: Path) -> Artefact:
    """Read an artefact and check its files.

    Raises:
        ExportError: It is none, of an unknown kind or schema, or a file is missing, changed or unexpected.
    """
    manifest = read_manifest(path)
    if fault := kind_fault(manifest):
        raise ExportError(fault, where=path / MANIFEST, cure=_CURE)
    content, faults = check_files(path, manifest)
    if faults:
        raise ExportError("; ".join(faults), where=path, cure=_CURE)
    return Artefact(path, manifest, content)


def kind_fault(manifest: Manifest) -> str | None:
    """What is wrong with the kind of an artefact; None where it is a model that this navtool knows."""
    fault = unknown_model(manifest.kind)
    return f"is of kind {manifest.kind!r}: {fault}" if fault else None


def check_files(path: Path, manifest: Manifest) -> tuple[dict[str, bytes], list[str]]:
    """The bytes of each file of the manifest, and every fault: missing, changed, unexpected, or a link."""
    faults = [
        f"{entry.name} is not in the manifest"
        for entry in sorted(path.iterdir())
        if entry.name not in {MANIFEST, *manifest.files}
    ]
    faults += [f"the manifest names no {name}" for name in (MODEL, GOLDEN) if name not in manifest.files]
    content: dict[str, bytes] = {}
    for name, entry in manifest.files.items():
        file = path / name
        if file.is_symlink() or not file.is_file():
            faults.append(f"{name} is missing" if not file.is_symlink() else f"{name} is a link")
        elif file.stat().st_size != entry.size:
            faults.append(f"{name} has {file.stat().st_size} bytes, the manifest says {entry.size}")
        else:
            data = file.read_bytes()
            if hashlib.sha256(data).hexdigest() == entry.sha256:
                content[name] = data
            else:
                faults.append(f"{name} was changed: its SHA-256 is not the manifest's")
    return content, faults
