"""Checking that an artefact is what its manifest says, before a robot relies on it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import safetensors.torch
import torch

from navtool.base.errors import NavtoolError
from navtool.base.plain import plain_fields
from navtool.export import model_checks
from navtool.export.artefact import MODEL, check_files, kind_fault
from navtool.export.golden import GOLDEN
from navtool.export.manifest import Manifest, read_manifest
from navtool.export.model_checks import CheckFailed, Subject, spec_fault
from navtool.export.scripted import load_scripted, told_by_script
from navtool.train.model_kind import AnyKind
from navtool.train.models import MODELS

VERIFY_SCHEMA = 1
"""Raised whenever the JSON form of a report changes its meaning."""

_MODEL_CHECKS: dict[str, Callable[[Subject], str]] = {
    "contract": model_checks.check_contract,
    "refusals": model_checks.check_refusals,
    "parity": model_checks.check_parity,
    "determinism": model_checks.check_determinism,
    "batch sizes": model_checks.check_batches,
}


@dataclass(frozen=True, slots=True)
class Check:
    """One thing that was looked at."""

    name: str
    ok: bool
    detail: str
    """What was seen."""


@dataclass(frozen=True, slots=True)
class VerifyReport:
    """What verification saw."""

    artefact: Path
    checks: tuple[Check, ...]
    """In the order in which they were made; the first three must hold for the rest to be made."""
    notes: tuple[str, ...] = ()
    """What was said of the model when its training was judged: it may be whole, and still worth nothing."""

    @property
    def passed(self) -> bool:
        """Whether every check holds."""
        return all(check.ok for check in self.checks)

    def to_json(self) -> dict[str, Any]:
        """Plain values."""
        return {"schema_version": VERIFY_SCHEMA, "passed": self.passed} | plain_fields(self)


def verify(artefact: Path, latency_runs: int = 20) -> VerifyReport:
    """Check an artefact on the CPU: manifest, hashes, contract, parity, determinism, latency.

    The hashes come first: nothing of a file is interpreted before its bytes are those of the manifest, and the bytes
    that were hashed are those that are loaded. Loading ``model.ts`` then runs the TorchScript in it. An artefact
    that is damaged in any way gives a report that says so, not an exception. Nothing is written.

    Args:
        artefact: Folder of the artefact.
        latency_runs: Runs whose median is reported, >= 1. Latency is reported, not judged.
    """
    checks: list[Check] = []
    manifest = _look(checks, "manifest", lambda: _manifest(artefact))
    content = _look(checks, "files", lambda: _files(artefact, manifest)) if manifest else None
    subject = _look(checks, "model and golden", lambda: _subject(manifest, content)) if manifest and content else None
    if manifest is not None and subject is not None:
        kind = MODELS[manifest.kind]
        with torch.inference_mode():
            for name, check in _checks(kind).items():
                _look(checks, name, partial(_seen, check, subject))
            _look(checks, "latency", lambda: (True, _latency(subject, kind, latency_runs)))
    return VerifyReport(artefact, tuple(checks), _training_notes(manifest))


def _training_notes(manifest: Manifest | None) -> tuple[str, ...]:
    """The notes on each split of the run's figures; none where the manifest holds no figures in our form."""
    splits = (manifest.metrics or {}).get("splits") if manifest is not None else None
    if not isinstance(splits, dict):
        return ()
    entries = ((name, judged.get("notes")) for name, judged in splits.items() if isinstance(judged, dict))
    return tuple(f"{name}: {note}" for name, notes in entries if isinstance(notes, list) for note in notes)


def _checks(kind: AnyKind) -> dict[str, Callable[[Subject], str]]:
    laws = {name: partial(model_checks.check_law, law=law) for name, law in kind.laws.items()}
    return {**_MODEL_CHECKS, **laws, "extremes": model_checks.check_extremes}


def _look[T](checks: list[Check], name: str, look: Callable[[], tuple[T, str]]) -> T | None:
    """Make a check and note it; whatever a damaged artefact raises is what was seen."""
    try:
        value, detail = look()
    except CheckFailed as failed:
        checks.append(Check(name, ok=False, detail=str(failed)))
    except NavtoolError as error:
        checks.append(Check(name, ok=False, detail=error.what))
    except Exception as error:
        checks.append(Check(name, ok=False, detail=f"{type(error).__name__}: {told_by_script(error)[:300]}"))
    else:
        checks.append(Check(name, ok=True, detail=detail))
        return value
    return None


def _seen(check: Callable[[Subject], str], subject: Subject) -> tuple[bool, str]:
    return True, check(subject)


def _manifest(artefact: Path) -> tuple[Manifest, str]:
    manifest = read_manifest(artefact)
    if fault := kind_fault(manifest):
        raise CheckFailed(fault)
    return manifest, f"{manifest.kind}, by {manifest.created_by}"


def _files(artefact: Path, manifest: Manifest) -> tuple[dict[str, bytes], str]:
    content, faults = check_files(artefact, manifest)
    if faults:
        raise CheckFailed("; ".join(faults))
    return content, f"{len(content)} files, {sum(map(len, content.values())) / 1e6:.1f} MB, SHA-256 as in the manifest"


def _subject(manifest: Manifest, content: dict[str, bytes]) -> tuple[Subject, str]:
    tensors = safetensors.torch.load(content[GOLDEN])
    specs = {f"input.{spec.name}": spec for spec in manifest.inputs}
    specs |= {f"output.{spec.name}": spec for spec in manifest.outputs}
    if tensors.keys() != specs.keys():
        raise CheckFailed(f"{GOLDEN} holds {sorted(tensors)}, the manifest declares {sorted(specs)}")
    batch = len(tensors[f"input.{manifest.inputs[0].name}"])
    faults = [fault for name, spec in specs.items() if (fault := spec_fault(spec, tensors[name], batch))]
    if faults:
        raise CheckFailed("golden " + "; ".join(faults))
    model = load_scripted(content[MODEL], torch.device("cpu"))
    missing = [name for name in manifest.methods if not hasattr(model, name)]
    if missing:
        raise CheckFailed(f"{MODEL} has no {', '.join(missing)}")
    inputs = tuple(tensors[f"input.{spec.name}"] for spec in manifest.inputs)
    expected = tuple(tensors[f"output.{spec.name}"] for spec in manifest.outputs)
    subject = Subject(manifest, model, inputs, expected)
    return subject, f"{MODEL} loads; {batch} golden samples from {manifest.golden_source}"


def _latency(subject: Subject, kind: AnyKind, runs: int) -> str:
    figures, rate_hz = [], 0.0
    for place, (what, timed) in enumerate(kind.timed.items()):
        median_ms = model_checks.latency_ms(subject, timed, runs if place == 0 else max(1, runs // 4))
        figures.append(f"{median_ms:.1f} ms for {what}")
        rate_hz = 1e3 / median_ms
    threads = torch.get_num_threads()
    return f"median {', '.join(figures)} ({rate_hz:.1f} Hz) on {threads} CPU thread{'s' if threads > 1 else ''}"
