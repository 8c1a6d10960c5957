"""Exporting: the same function as the trained network, whole or not at all."""

import json
from pathlib import Path

import pytest
import safetensors.torch
import torch

from navtool.base.errors import DatasetsError, OutputError
from navtool.export import torchscript
from navtool.export.artefact import open_artefact
from navtool.export.errors import ExportError
from navtool.export.manifest import read_manifest
from navtool.export.scripted import SCRIPT_ERRORS, told_by_script
from navtool.export.torchscript import export_run
from navtool.train.checkpoint import load_run
from navtool.train.datamodule import sample_loader
from navtool.train.errors import TrainError
from navtool.train.success.samples import Sample, SampleDataset
from navtool.train.success.windows import DataConfig, plan_windows
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

CPU = torch.device("cpu")


@pytest.fixture(scope="module")
def batch(world: SyntheticConfig) -> Sample:
    """Eight samples."""
    source = SyntheticSource(world)
    dataset = SampleDataset(source, plan_windows(source, [0, 1, 2], DataConfig()), DataConfig())
    loaded: Sample = next(iter(sample_loader(dataset, 8, workers=0)))
    return loaded


def test_the_artefact_computes_what_the_run_computes(exported: Path, run: Path, batch: Sample) -> None:
    with torch.inference_mode():
        eager = load_run(run).model(*batch.inputs())
        scripted = open_artefact(exported).load(CPU)(*batch.inputs())
    assert eager.std() > 1e-3
    torch.testing.assert_close(scripted, eager, atol=1e-5, rtol=0.0)


def test_candidates_share_an_encoding(exported: Path, batch: Sample) -> None:
    model = open_artefact(exported).load(CPU)
    image, points, count, velocity, trajectory, reliability = batch.inputs()
    candidates = torch.stack([trajectory, 255 - trajectory, torch.zeros_like(trajectory)], dim=1)
    with torch.inference_mode():
        features = model.encode_sensors(image, points, count, velocity)
        scores = model.score_candidates(features, candidates, reliability)
        alone = [model(image, points, count, velocity, candidates[:, k], reliability) for k in range(3)]
    torch.testing.assert_close(scores, torch.stack(alone, dim=1), atol=1e-5, rtol=0.0)


@pytest.mark.parametrize(
    ("place", "change", "message"),
    [
        (0, lambda t: t.float(), "image must be uint8"),
        (0, lambda t: t[:, :, :-1], "image must be uint8"),
        (1, lambda t: t[..., :2], "points must be float32"),
        (2, lambda t: t + 10_000, "count must lie between"),
        (2, lambda t: t.int(), "count must be int64"),
        (3, lambda t: t[:, 1:], "velocity must be float32"),
        (4, lambda t: t[:, 0], "trajectory must be"),
        (4, lambda t: t[:-1], "trajectory must be uint8"),
        (5, lambda t: t[:, :1], "reliability must be float32"),
    ],
)
def test_wrong_inputs_are_refused_with_a_message(
    exported: Path, batch: Sample, place: int, change: "object", message: str
) -> None:
    assert callable(change)
    inputs = list(batch.inputs())
    inputs[place] = change(inputs[place])
    with pytest.raises(SCRIPT_ERRORS) as caught:
        open_artefact(exported).load(CPU)(*inputs)
    assert message in told_by_script(caught.value)


def test_the_manifest_says_what_the_artefact_is(exported: Path, run: Path) -> None:
    manifest = read_manifest(exported)
    assert [spec.name for spec in manifest.inputs] == [
        "image",
        "points",
        "count",
        "velocity",
        "trajectory",
        "reliability",
    ]
    assert manifest.inputs[0].shape == ("batch", 3, 48, 64)
    assert manifest.outputs[0].shape == ("batch", 10)
    lineage = json.loads((run / "lineage.json").read_text(encoding="utf-8"))
    assert manifest.lineage["config_hash"] == lineage["config_hash"]
    assert manifest.lineage["code_version"] == lineage["code_version"]
    assert manifest.lineage["dataset"] == lineage["dataset"]
    assert "dataset_path" not in manifest.lineage
    assert manifest.metrics == {"best_val_loss": 0.25}
    assert sorted(manifest.files) == ["golden.safetensors", "model.ts"]
    assert manifest.golden_source.startswith("synthetic")  # this run's data set was never in a folder


def test_the_golden_tensors_are_the_networks(exported: Path, run: Path) -> None:
    golden = safetensors.torch.load(open_artefact(exported).content["golden.safetensors"])
    inputs = [golden[f"input.{spec.name}"] for spec in read_manifest(exported).inputs]
    with torch.inference_mode():
        torch.testing.assert_close(load_run(run).model(*inputs), golden["output.success"], atol=1e-6, rtol=0.0)


def test_exporting_twice_gives_the_same_golden_file_and_contract(exported: Path, run: Path, tmp_path: Path) -> None:
    again = export_run(run, tmp_path / "again")
    assert (again / "golden.safetensors").read_bytes() == (exported / "golden.safetensors").read_bytes()
    one, other = read_manifest(exported), read_manifest(again)
    assert (one.inputs, one.outputs, one.lineage) == (other.inputs, other.outputs, other.lineage)


def test_an_artefact_is_replaced_only_on_request(artefact: Path, run: Path) -> None:
    (artefact / "model.ts").write_bytes(b"old")
    with pytest.raises(ExportError, match="holds an artefact already"):
        export_run(run, artefact)
    assert (artefact / "model.ts").read_bytes() == b"old"
    export_run(run, artefact, overwrite=True)
    assert open_artefact(artefact).manifest.kind == "graspe"
    assert [path.name for path in artefact.parent.iterdir()] == [artefact.name]


def test_other_files_are_never_replaced(run: Path, tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(DatasetsError, match="holds something else"):
        export_run(run, tmp_path, overwrite=True)
    with pytest.raises(DatasetsError, match="is a file"):
        export_run(run, tmp_path / "thesis.tex", overwrite=True)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_an_empty_folder_is_filled(run: Path, tmp_path: Path) -> None:
    (tmp_path / "artefact").mkdir()
    assert open_artefact(export_run(run, tmp_path / "artefact")).content.keys() == {"model.ts", "golden.safetensors"}


def test_a_failure_leaves_nothing(run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(torchscript, "write_json", full)
    with pytest.raises(OutputError, match="No space left"):
        export_run(run, tmp_path / "artefact")
    assert list(tmp_path.iterdir()) == []


def test_a_run_without_checkpoint_cannot_be_exported(run: Path, tmp_path: Path) -> None:
    with pytest.raises(TrainError, match="no such checkpoint"):
        export_run(run, tmp_path / "artefact", checkpoint="last")
    assert list(tmp_path.iterdir()) == []
