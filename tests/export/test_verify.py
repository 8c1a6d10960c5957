"""Verification: passes on what was exported, names every damage, and never falls over."""

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import safetensors.torch
import torch
from torch import Tensor

from navtool.export.manifest import MANIFEST, digest
from navtool.export.scripted import load_scripted, save_scripted, script
from navtool.export.verify import VerifyReport, verify
from navtool.train.checkpoint import load_run
from navtool.train.config import TrainConfig
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.contract import METHODS
from navtool.train.graspe.graspe import Graspe
from navtool.train.graspe.onboard import OnboardGraspe


def failed(report: VerifyReport) -> dict[str, str]:
    return {check.name: check.detail for check in report.checks if not check.ok}


def edit(artefact: Path, change: Callable[[dict[str, Any]], None], *, sealed: bool) -> None:
    """Change the manifest; sealed = with its digest made right again."""
    path = artefact / MANIFEST
    content = json.loads(path.read_text(encoding="utf-8"))
    change(content)
    if sealed:
        content["digest"] = digest(content)
    path.write_text(json.dumps(content), encoding="utf-8")


def exchange(artefact: Path, name: str, data: bytes) -> None:
    """Put other bytes into a file and make the manifest agree, as a forger would."""
    (artefact / name).write_bytes(data)
    entry = {"sha256": hashlib.sha256(data).hexdigest(), "size": len(data)}
    edit(artefact, lambda content: content["files"].update({name: entry}), sealed=True)


def test_what_was_said_of_the_training_is_told_again(exported: Path, tmp_path: Path) -> None:
    artefact = Path(shutil.copytree(exported, tmp_path / "artefact"))
    told = ["the model says success of every trajectory"]
    edit(artefact, lambda content: content.update(metrics={"splits": {"test": {"notes": told}}}), sealed=True)
    report = verify(artefact, 1)
    assert report.passed, "it is whole all the same"
    assert report.notes == (f"test: {told[0]}",)
    edit(artefact, lambda content: content.update(metrics={"splits": {"test": {"notes": 3}, "val": []}}), sealed=True)
    assert verify(artefact, 1).notes == (), "figures of another form say nothing"


def test_an_exported_artefact_passes(exported: Path) -> None:
    before = {path.name: path.stat().st_mtime_ns for path in exported.iterdir()}
    report = verify(exported, 2)
    assert failed(report) == {}
    assert report.passed
    names = [check.name for check in report.checks]
    assert names[:3] == ["manifest", "files", "model and golden"]
    assert {"contract", "refusals", "parity", "determinism", "batch sizes", "candidates", "extremes", "latency"} <= set(
        names
    )
    assert {path.name: path.stat().st_mtime_ns for path in exported.iterdir()} == before
    content = report.to_json()
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert content["passed"] is True


@pytest.mark.parametrize("name", ["model.ts", "golden.safetensors"])
def test_one_flipped_bit_is_found_before_anything_is_loaded(artefact: Path, name: str) -> None:
    data = bytearray((artefact / name).read_bytes())
    data[len(data) // 2] ^= 1
    (artefact / name).write_bytes(data)
    report = verify(artefact, 1)
    assert failed(report) == {"files": f"{name} was changed: its SHA-256 is not the manifest's"}
    assert [check.name for check in report.checks] == ["manifest", "files"]


def test_an_edited_manifest_is_found(artefact: Path) -> None:
    edit(artefact, lambda content: content["metrics"].update(best_val_loss=0.0), sealed=False)
    assert "digest does not match" in failed(verify(artefact, 1))["manifest"]


@pytest.mark.parametrize(
    ("change", "check", "message"),
    [
        (lambda c: c.update(schema_version=2), "manifest", "schema version 2; this navtool reads 1"),
        (lambda c: c.update(kind="paad"), "manifest", "kind 'paad'"),
        (lambda c: c.pop("inputs"), "manifest", "inputs"),
        (lambda c: c.update(golden_tolerance="much"), "manifest", "golden_tolerance"),
        (lambda c: c["inputs"][0].update(shape=[-1]), "manifest", "shape"),
        (lambda c: c["files"].update({"../escape": c["files"]["model.ts"]}), "manifest", "not a plain name"),
        (lambda c: c["files"].update({"/etc/passwd": c["files"]["model.ts"]}), "manifest", "not a plain name"),
        (lambda c: c["files"].update({"a/b": c["files"]["model.ts"]}), "manifest", "not a plain name"),
        (lambda c: c["files"].update({"more.bin": c["files"]["model.ts"]}), "files", "more.bin is missing"),
        (lambda c: c["files"].pop("model.ts"), "files", "the manifest names no model.ts"),
        (lambda c: c["inputs"][0].update(dtype="float32"), "model and golden", "declared float32"),
        (lambda c: c["inputs"][0].update(range=[0, 10]), "model and golden", "declared 0 to 10"),
        (lambda c: c["outputs"][0].update(shape=["batch", 9]), "model and golden", "declared ['batch', 9]"),
        (lambda c: c.update(methods=["forward", "steer"]), "model and golden", "no steer"),
    ],
)
def test_a_manifest_that_does_not_fit_is_named(
    artefact: Path, change: Callable[[dict[str, Any]], None], check: str, message: str
) -> None:
    edit(artefact, change, sealed=True)
    assert message in failed(verify(artefact, 1))[check]


def test_a_file_too_many_a_folder_and_a_link_are_found(artefact: Path, tmp_path: Path) -> None:
    (artefact / "extra.py").write_text("print(1)")
    (artefact / "more").mkdir()
    assert failed(verify(artefact, 1))["files"] == "extra.py is not in the manifest; more is not in the manifest"
    (artefact / "extra.py").unlink()
    (artefact / "more").rmdir()
    shutil.move(artefact / "model.ts", tmp_path / "elsewhere.ts")
    (artefact / "model.ts").symlink_to(tmp_path / "elsewhere.ts")
    assert failed(verify(artefact, 1))["files"] == "model.ts is a link"


def test_other_weights_with_right_hashes_fail_parity(
    artefact: Path, run: Path, config: TrainConfig, tmp_path: Path
) -> None:
    model = load_run(run).model
    assert isinstance(model, Graspe)
    with torch.no_grad():
        model.agnn.out.bias.add_(0.01)
    assert isinstance(config.model, GraspeConfig)
    other = script(OnboardGraspe(model, config.model), METHODS)
    save_scripted(other, tmp_path / "other.ts")
    exchange(artefact, "model.ts", (tmp_path / "other.ts").read_bytes())
    report = verify(artefact, 1)
    assert set(failed(report)) == {"parity"}
    assert "allowed 1e-05" in failed(report)["parity"]


def test_a_looser_tolerance_in_the_manifest_does_not_help(artefact: Path) -> None:
    golden = safetensors.torch.load((artefact / "golden.safetensors").read_bytes())
    golden["output.success"] = golden["output.success"] * 0.9
    exchange(artefact, "golden.safetensors", safetensors.torch.save(golden))
    edit(artefact, lambda content: content.update(golden_tolerance=1.0), sealed=True)
    assert set(failed(verify(artefact, 1))) == {"parity"}


class Unchecked(torch.nn.Module):
    """Takes anything, gives something of the right shape that is no probability."""

    def forward(
        self, image: Tensor, _points: Tensor, _count: Tensor, _velocity: Tensor, _trajectory: Tensor, _r: Tensor
    ) -> Tensor:
        return torch.rand(image.shape[0], 10) + 1.0

    @torch.jit.export
    def encode_sensors(self, _image: Tensor, _points: Tensor, _count: Tensor, velocity: Tensor) -> Tensor:
        return velocity

    @torch.jit.export
    def score_candidates(self, features: Tensor, trajectory: Tensor, _reliability: Tensor) -> Tensor:
        return torch.rand(features.shape[0], trajectory.shape[1], 10)


@pytest.mark.filterwarnings("ignore:`torch.jit:DeprecationWarning")
def test_another_model_fails_every_check_of_behaviour(artefact: Path, tmp_path: Path) -> None:
    torch.jit.save(torch.jit.script(Unchecked()), str(tmp_path / "other.ts"))
    exchange(artefact, "model.ts", (tmp_path / "other.ts").read_bytes())
    assert set(failed(verify(artefact, 1))) == {
        "contract",
        "refusals",
        "parity",
        "determinism",
        "batch sizes",
        "candidates",
        "extremes",
    }


def test_no_damage_makes_it_fall_over(artefact: Path, exported: Path) -> None:
    rng = np.random.default_rng(0)
    for name in ("manifest.json", "model.ts", "golden.safetensors"):
        whole = (exported / name).read_bytes()
        positions = rng.integers(0, len(whole), 6).tolist()
        damages = [whole[:length] for length in (0, 1, len(whole) // 3, len(whole) - 2)]
        damages += [
            whole[:at] + bytes([whole[at] ^ (1 << bit % 8)]) + whole[at + 1 :] for bit, at in enumerate(positions)
        ]
        damages += [
            rng.bytes(200),
            b"\x80\x04",
            b"[" * 100_000,
            b"null",
            b"{}",
            b'{"schema_version": 1}',
            whole + b" x",
        ]
        for damage in damages:
            (artefact / name).write_bytes(damage)
            report = verify(artefact, 1)
            assert not report.passed, (name, damage[:40])
            assert failed(report).keys() <= {"manifest", "files"}
        (artefact / name).unlink()
        assert not verify(artefact, 1).passed
        (artefact / name).mkdir()
        assert not verify(artefact, 1).passed
        (artefact / name).rmdir()
        (artefact / name).write_bytes(whole)
    assert verify(artefact, 1).passed


def test_damage_with_right_hashes_does_not_make_it_fall_over_either(artefact: Path, exported: Path) -> None:
    for name in ("model.ts", "golden.safetensors"):
        whole = (exported / name).read_bytes()
        for damage in (b"", b"garbage", whole[: len(whole) // 2], b"PK\x05\x06" + bytes(18), b"\xff" * 64):
            exchange(artefact, name, damage)
            assert set(failed(verify(artefact, 1))) == {"model and golden"}
        exchange(artefact, name, whole)
    assert verify(artefact, 1).passed


@pytest.mark.parametrize("field", ["inputs", "outputs", "files", "config", "methods", "metrics", "lineage", "digest"])
def test_any_kind_of_json_in_any_field_gives_a_report(artefact: Path, field: str) -> None:
    values: tuple[object, ...] = (3, "x", [3], [], {"a": 1}, True, 1e308, [None], [[]], [{}], {"model.ts": 3})
    (artefact / "model.ts").unlink()  # what a report says of the manifest does not need the model
    original = (artefact / MANIFEST).read_bytes()
    for value in values:
        (artefact / MANIFEST).write_bytes(original)
        edit(artefact, partial(put, field=field, value=value), sealed=field != "digest")
        report = verify(artefact, 1)
        assert not report.passed
        assert "Error" not in failed(report).get("files", "")


def put(content: dict[str, Any], field: str, value: object) -> None:
    content[field] = value


def test_what_is_no_artefact_is_named(tmp_path: Path) -> None:
    assert "no such folder" in failed(verify(tmp_path / "nowhere", 1))["manifest"]
    assert "no manifest.json" in failed(verify(tmp_path, 1))["manifest"]
    (tmp_path / "file").touch()
    assert "no such folder" in failed(verify(tmp_path / "file", 1))["manifest"]


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission_is_named(artefact: Path) -> None:
    (artefact / "model.ts").chmod(0)
    assert "files" in failed(verify(artefact, 1))


def test_bytes_that_are_no_torchscript_are_refused() -> None:
    with pytest.raises(RuntimeError):
        load_scripted(b"nothing", torch.device("cpu"))
