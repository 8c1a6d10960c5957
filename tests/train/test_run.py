"""A run: what it leaves, that it resumes to the bit, and how it refuses."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from counted import Counted
from numpy.typing import NDArray
from tensorboard.backend.event_processing.event_accumulator import (  # type: ignore[import-untyped]  # no types
    EventAccumulator,
)

from navtool.train.checkpoint import load_run, read_checkpoint
from navtool.train.config import OptimizerConfig, Precision, TrainConfig
from navtool.train.errors import TrainError
from navtool.train.evaluate import Origin, evaluate_scorer
from navtool.train.graspe.config import GraspeConfig
from navtool.train.run import RunResult, train_source
from navtool.train.run_folder import RunFolder
from navtool.train.splits import Split
from navtool.train.success.windows import DataConfig
from navtool.train.synthetic import SyntheticConfig, SyntheticSource


class Interrupted(SyntheticSource):
    """Somebody presses Ctrl-C while the frame ``reads`` reads from now is fetched."""

    reads = -1

    def image(self, row: int) -> NDArray[np.uint8]:
        self.reads -= 1
        if self.reads == 0:
            raise KeyboardInterrupt
        return super().image(row)


@pytest.fixture(scope="module")
def finished(
    small_config: TrainConfig, small_world: SyntheticConfig, tmp_path_factory: pytest.TempPathFactory
) -> RunResult:
    """Three epochs without a stop."""
    return train_source(epochs(small_config, 3), SyntheticSource(small_world), tmp_path_factory.mktemp("run") / "whole")


def epochs(config: TrainConfig, count: int) -> TrainConfig:
    return replace(config, trainer=replace(config.trainer, epochs=count))


def leaves(value: Any, prefix: str = "") -> dict[str, Any]:
    if isinstance(value, dict):
        return {name: leaf for key, entry in value.items() for name, leaf in leaves(entry, f"{prefix}/{key}").items()}
    if isinstance(value, list):
        return leaves(dict(enumerate(value)), prefix)
    return {prefix: value}


def assert_same_state(one: Path, other: Path) -> None:
    """Weights, running statistics and the optimiser's moments agree to the bit."""
    states = [read_checkpoint(RunFolder(run).last) for run in (one, other)]
    first, second = (leaves({key: state[key] for key in ("state_dict", "optimizer_states")}) for state in states)
    assert first.keys() == second.keys()
    assert len(first) > 100
    different = [
        name
        for name, value in first.items()
        if not (torch.equal(value, second[name]) if isinstance(value, torch.Tensor) else value == second[name])
    ]
    assert different == []


def test_a_run_leaves_what_it_promises(finished: RunResult, small_config: TrainConfig) -> None:
    folder = RunFolder(finished.run)
    assert folder.read_config() == epochs(small_config, 3)
    assert folder.last.is_file()
    assert folder.best.is_file()
    metrics = folder.read_metrics()
    assert metrics is not None
    assert metrics["best_val_loss"] == finished.best_val_loss
    assert metrics["splits"].keys() == {"val", "test"}
    assert metrics["splits"]["val"]["loss"] == pytest.approx(finished.best_val_loss, abs=1e-6)
    assert finished.epochs == 3
    lineage = folder.read_lineage()
    assert {"dataset", "config_hash", "code_version", "split", "samples"} <= lineage.keys()
    assert [len(lineage["split"][split]) for split in ("train", "val", "test")] == [1, 1, 1]
    assert [path.name for path in sorted(folder.checkpoints.iterdir())] == ["best.ckpt", "last.ckpt"]


def test_tensorboard_gets_the_named_figures(finished: RunResult) -> None:
    events = EventAccumulator(str(RunFolder(finished.run).tensorboard)).Reload()
    names = {
        "train/loss",
        "val/loss",
        "val/ap",
        "val/fpr",
        "val/fnr",
        "lr-Adam",
        "perf/samples_per_s",
        "perf/data_wait_s",
    }
    assert names <= set(events.Tags()["scalars"])
    assert len(events.Scalars("train/loss")) == 3
    assert events.Scalars("lr-Adam")[0].value == pytest.approx(0.002)
    assert len(events.Images("val/predictions")) == 3  # after epochs 1, 2 and the last


def test_the_best_checkpoint_is_the_one_with_the_smallest_loss(
    finished: RunResult, small_world: SyntheticConfig
) -> None:
    losses = [e.value for e in EventAccumulator(str(finished.run / "tensorboard")).Reload().Scalars("val/loss")]
    assert losses[finished.best_epoch] == pytest.approx(min(losses))
    loaded = load_run(finished.run)
    report = evaluate_scorer(
        loaded.model,
        SyntheticSource(small_world),
        Split.val,
        origin=Origin("run", "run", loaded.config, loaded.lineage),
        device=torch.device("cpu"),
    )
    assert report.loss == pytest.approx(min(losses), abs=1e-6)


def test_an_interrupted_run_resumes_to_the_bit(
    finished: RunResult, small_config: TrainConfig, small_world: SyntheticConfig, tmp_path: Path
) -> None:
    run, config = tmp_path / "run", replace(epochs(small_config, 3), data=replace(small_config.data, cache_mib=0))
    source = Interrupted(small_world)
    source.reads = 5
    with pytest.raises(TrainError, match="interrupted; before its first epoch was complete"):
        train_source(config, source, run)
    source.reads = 12 + 12 + 1 + 6  # training, validation and figure of an epoch, and into the second
    with pytest.raises(TrainError, match="interrupted; its whole epochs are kept") as caught:
        train_source(config, source, run, resume=True)
    assert caught.value.cure == "resume the run"
    assert read_checkpoint(RunFolder(run).last)["epoch"] == 0
    progress = Counted()
    result = train_source(config, SyntheticSource(small_world), run, resume=True, progress=progress)
    assert progress.adds_up()
    assert [things for things, _ in progress.finished] == [1, 2]
    assert result.epochs == 3
    assert_same_state(run, finished.run)
    assert (result.best_epoch, result.best_val_loss) == (finished.best_epoch, finished.best_val_loss)


def test_a_finished_run_is_not_overwritten(
    finished: RunResult, small_config: TrainConfig, small_world: SyntheticConfig
) -> None:
    before = RunFolder(finished.run).last.read_bytes()
    with pytest.raises(TrainError, match="holds a run already"):
        train_source(small_config, SyntheticSource(small_world), finished.run)
    assert RunFolder(finished.run).last.read_bytes() == before


def test_resuming_with_other_settings_names_them(
    finished: RunResult, small_config: TrainConfig, small_world: SyntheticConfig
) -> None:
    changed = replace(small_config, optimizer=OptimizerConfig(learning_rate=0.1))
    with pytest.raises(TrainError, match=r"optimizer.learning_rate \(0.002 before, 0.1 now\)"):
        train_source(changed, SyntheticSource(small_world), finished.run, resume=True)


def test_resuming_on_changed_labels_is_refused(
    finished: RunResult, small_config: TrainConfig, small_world: SyntheticConfig
) -> None:
    relabelled = SyntheticSource(small_world)
    relabelled.columns["label.outcome"] = 1 - relabelled.columns["label.outcome"].astype(np.int64)
    with pytest.raises(TrainError, match="samples changed since the run began"):
        train_source(epochs(small_config, 4), relabelled, finished.run, resume=True)


def test_a_folder_with_other_files_is_left_alone(
    small_config: TrainConfig, small_world: SyntheticConfig, tmp_path: Path
) -> None:
    (tmp_path / "thesis.tex").write_text("mine")
    with pytest.raises(TrainError, match=r"thesis\.tex"):
        train_source(small_config, SyntheticSource(small_world), tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.tex"]


def test_a_loss_that_is_not_finite_stops_the_run(
    small_config: TrainConfig, small_world: SyntheticConfig, tmp_path: Path
) -> None:
    wild = replace(small_config, optimizer=OptimizerConfig(learning_rate=1e30))
    with pytest.raises(TrainError, match="loss is nan in epoch 0") as caught:
        train_source(wild, SyntheticSource(small_world), tmp_path / "run")
    assert caught.value.cure is not None
    assert "learning_rate" in caught.value.cure


def test_nothing_is_written_where_the_data_do_not_fit(
    small_config: TrainConfig, small_world: SyntheticConfig, tmp_path: Path
) -> None:
    assert isinstance(small_config.model, GraspeConfig)
    bad = replace(small_config, model=replace(small_config.model, horizon=12), data=DataConfig(horizon_steps=12))
    with pytest.raises(TrainError, match="labels 10 steps ahead"):
        train_source(bad, SyntheticSource(small_world), tmp_path / "run")
    assert not (tmp_path / "run").exists()


def test_metrics_are_plain_json(finished: RunResult) -> None:
    text = RunFolder(finished.run).metrics.read_text(encoding="utf-8")
    assert "NaN" not in text
    assert json.loads(text)["schema_version"] == 1


def test_every_option_trains(small_config: TrainConfig, small_world: SyntheticConfig, tmp_path: Path) -> None:
    options = replace(
        small_config.trainer,
        epochs=1,
        precision=Precision.bf16,
        channels_last=True,
        workers=1,
        gradient_clip=1.0,
        figure_samples=0,
    )
    result = train_source(replace(small_config, trainer=options), SyntheticSource(small_world), tmp_path / "run")
    assert 0.0 < result.best_val_loss < 1.0
    assert load_run(result.run).model.training is False
