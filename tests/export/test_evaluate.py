"""The whole way on files: train, resume, evaluate, export, verify, and judge the artefact."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from navtool.export.errors import ExportError
from navtool.export.evaluate import evaluate_artefact, evaluate_source
from navtool.export.manifest import read_manifest
from navtool.export.torchscript import export_run
from navtool.export.verify import verify
from navtool.train.config import Device, Precision, TrainConfig, TrainerConfig
from navtool.train.errors import TrainError
from navtool.train.graspe.config import GraspeConfig
from navtool.train.run import resume, train
from navtool.train.run_folder import RunFolder
from navtool.train.splits import SplitConfig


@pytest.fixture(scope="module")
def trained(labelled_dataset: Path, config: TrainConfig, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One epoch on one of the three recorded places."""
    network = config.model
    assert isinstance(network, GraspeConfig)
    settings = TrainConfig(
        model=replace(network, image_height=240, image_width=320),
        trainer=TrainerConfig(
            epochs=1, batch_size=16, device=Device.cpu, precision=Precision.bf16, channels_last=True, figure_samples=1
        ),
        split=SplitConfig(train_places=["place-0"], val_places=["place-1"], test_places=["place-2"]),
    )
    return train(settings, labelled_dataset, tmp_path_factory.mktemp("trained") / "run").run


@pytest.fixture(scope="module")
def artefact(trained: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The artefact of that run."""
    return export_run(trained, tmp_path_factory.mktemp("artefact") / "artefact")


@pytest.mark.slow
def test_an_artefact_of_recorded_data_verifies(artefact: Path) -> None:
    report = verify(artefact, 1)
    assert report.passed, [check for check in report.checks if not check.ok]
    manifest = read_manifest(artefact)
    assert manifest.golden_source.startswith("data set rows [")
    recordings = manifest.lineage["dataset"]["recordings"]
    assert len(recordings) == 4
    assert all(len(entry["sha256"]) == 64 for entry in recordings)
    assert manifest.metrics is not None
    assert manifest.metrics["epochs"] == 1


@pytest.mark.slow
def test_the_run_and_its_artefact_get_the_same_figures(
    trained: Path, artefact: Path, labelled_dataset: Path, tmp_path: Path
) -> None:
    of_run = evaluate_source(trained, None, "test", tmp_path / "run.json")
    of_artefact = evaluate_source(artefact, labelled_dataset, "test", tmp_path / "artefact.json")
    assert (of_run.kind, of_artefact.kind) == ("run", "artefact")
    assert of_run.windows == of_artefact.windows
    assert of_run.loss == pytest.approx(of_artefact.loss, abs=1e-6)
    for (name, *run_figures), (_, *artefact_figures) in zip(of_run.table.rows, of_artefact.table.rows, strict=True):
        # average precision is a matter of ranks: samples that are nearly tied change places on rounding
        tolerance = 0.02 if str(name).startswith("average_precision") else 1e-5
        assert run_figures == pytest.approx(artefact_figures, abs=tolerance), name
    assert json.loads((tmp_path / "run.json").read_text(encoding="utf-8")) == of_run.to_json()
    stored = RunFolder(trained).read_metrics()
    assert stored is not None
    assert stored["splits"]["test"]["metrics"]["trajectory"] == of_run.to_json()["metrics"]["trajectory"]


@pytest.mark.slow
def test_a_run_goes_on_where_nothing_is_left_to_do(trained: Path) -> None:
    before = RunFolder(trained).last.read_bytes()
    result = resume(trained)
    assert (result.epochs, result.samples_per_s) == (1, 0.0)
    assert RunFolder(trained).last.read_bytes() == before


def test_a_damaged_artefact_is_not_judged(exported: Path, tmp_path: Path) -> None:
    copy = shutil.copytree(exported, tmp_path / "copy")
    (copy / "model.ts").write_bytes(b"other")
    with pytest.raises(ExportError, match=r"model\.ts has 5 bytes"):
        evaluate_artefact(copy, tmp_path)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda run, _: evaluate_source(run, None, "exam"), "there is no split 'exam'"),
        (lambda run, _: evaluate_source(run, None, "test"), "does not say where the run's data set is"),
        (lambda _, exported: evaluate_source(exported, None, "test"), "does not know where its data set is"),
        (lambda run, _: evaluate_source(run.parent, None, "test"), "not a training run"),
        (lambda run, _: resume(run), "does not say where the run's data set is"),
    ],
)
def test_what_cannot_be_judged_has_a_cure(
    run: Path, exported: Path, call: Callable[[Path, Path], object], message: str
) -> None:
    with pytest.raises((TrainError, ExportError), match=message) as caught:
        call(run, exported)
    assert caught.value.cure
