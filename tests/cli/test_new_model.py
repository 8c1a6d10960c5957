"""A model that navtool has never heard of: one row of the table and one YAML file take it through every command."""

import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
import torch
from torch import Tensor, nn

from navtool.export.torchscript import export_run
from navtool.export.verify import verify
from navtool.train.checkpoint import read_checkpoint
from navtool.train.config import Device, TrainConfig, TrainerConfig
from navtool.train.contract import Contract, TensorSpec
from navtool.train.evaluate import evaluate_run
from navtool.train.layers.checked_input import check_input
from navtool.train.model_config import ModelConfig
from navtool.train.model_kind import ModelKind
from navtool.train.models import MODELS
from navtool.train.run import train
from navtool.train.run_folder import RunFolder
from navtool.train.splits import SplitConfig
from navtool.train.success.task import SUCCESS
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

WORLD = SyntheticConfig(rows=24, image_height=48, image_width=64, points=10)


@dataclass(kw_only=True, slots=True)
class ToyConfig(ModelConfig):
    hidden: int = 4


class Toy(nn.Module):
    def __init__(self, config: ToyConfig) -> None:
        super().__init__()
        layers = (nn.Linear(100, config.hidden), nn.ReLU(), nn.Dropout(0.2), nn.Linear(config.hidden, 10))
        self.layers = nn.Sequential(*layers)

    def forward(self, velocity: Tensor) -> Tensor:
        check_input(velocity, "velocity", "float32", [-1, 50, 2])
        return torch.sigmoid(self.layers(velocity.flatten(1)))


TOY = ModelKind(
    task=replace(SUCCESS, open=lambda _path: SyntheticSource(WORLD)),
    config=ToyConfig,
    build=Toy,
    inputs=lambda sample: (sample.velocity,),
    stand_in=lambda _config: SyntheticSource(WORLD),
    contract=lambda _config: Contract(
        (TensorSpec("velocity", ("batch", 50, 2), "float32", "m/s, rad/s", None, "[v, omega] of base"),),
        (TensorSpec("success", ("batch", 10), "float32", "1", (0, 1), "success at each step"),),
    ),
    onboard=lambda network, _config: network,
)


@pytest.fixture(autouse=True)
def _known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(MODELS, "toy", TOY)


@pytest.fixture
def options(tmp_path: Path) -> list[str]:
    """What chooses the toy on the command line: its YAML file lies outside of navtool."""
    (tmp_path / "own" / "model").mkdir(parents=True)
    (tmp_path / "own" / "model" / "toy.yaml").write_text("defaults: [toy_schema]\n")
    return ["--data", str(tmp_path), f"hydra.searchpath=[file://{tmp_path / 'own'}]", "model=toy", "trainer.epochs=1"]


def config(epochs: int) -> TrainConfig:
    trainer = TrainerConfig(epochs=epochs, batch_size=8, device=Device.cpu, figure_samples=1)
    split = SplitConfig(train_places=["wood"], val_places=["park"], test_places=["field"])
    return TrainConfig(model=ToyConfig(hidden=3), trainer=trainer, split=split)


def test_it_trains_evaluates_exports_and_verifies(tmp_path: Path) -> None:
    result = train(config(2), tmp_path, tmp_path / "run")
    report = evaluate_run(result.run, tmp_path)
    stored = RunFolder(result.run).read_metrics()
    assert stored is not None
    assert report.samples == 24
    assert report.loss == pytest.approx(stored["splits"]["test"]["loss"])
    verification = verify(export_run(result.run, tmp_path / "artefact"), 1)
    assert verification.passed, [check for check in verification.checks if not check.ok]
    assert "candidates" not in [check.name for check in verification.checks], "that law is another model's"


def test_it_resumes_to_the_bit(tmp_path: Path) -> None:
    whole = train(config(3), tmp_path, tmp_path / "whole")
    train(config(1), tmp_path, tmp_path / "stopped")
    resumed = train(config(3), tmp_path, tmp_path / "stopped", resume=True)
    assert (resumed.best_val_loss, resumed.best_epoch) == (whole.best_val_loss, whole.best_epoch)
    one, other = (read_checkpoint(RunFolder(result.run).last) for result in (whole, resumed))
    assert one["epoch"] == other["epoch"] == 2
    assert all(torch.equal(tensor, other["state_dict"][name]) for name, tensor in one["state_dict"].items())


def test_it_sweeps(navtool_here: Callable[..., Any], options: list[str], tmp_path: Path) -> None:
    done = navtool_here("train", "-m", "--out", tmp_path / "sweep", *options, "model.hidden=2,5")
    assert done.code == 0, done.err
    jobs = json.loads((tmp_path / "sweep" / "summary.json").read_text())["jobs"]
    assert [(job["finished"], job["overrides"][-1]) for job in jobs] == [
        (True, "model.hidden=2"),
        (True, "model.hidden=5"),
    ]
    stored = json.loads((tmp_path / "sweep" / "1" / "config.json").read_text())
    assert (stored["model"], stored["config"]["model"]) == ("toy", {"hidden": 5})


def test_a_misspelt_model_lists_the_known_ones(navtool_here: Callable[..., Any], options: list[str]) -> None:
    done = navtool_here("train", *options, "model=toi")
    assert done.code == 2
    assert "no model is called 'toi' (did you mean toy?)" in done.err
    assert "known are graspe, toy" in done.err
