"""Every experiment and every debug configuration runs a step, on data made of numbers."""

from pathlib import Path

import pytest

from navtool.cli.compose import compose
from navtool.configs.schema import config_folder
from navtool.configs.train_job import TrainJob
from navtool.train.run import train_source
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

TINY = (
    "dataset=none",
    "trainer.epochs=1",
    "trainer.device=cpu",
    "trainer.figure_samples=0",
    "model.image_height=48",
    "model.image_width=64",
    "split.train_places=[wood]",
    "split.val_places=[park]",
    "split.test_places=[field]",
)
CHOICES = [f"{group}={path.stem}" for group in ("experiment", "debug") for path in (config_folder() / group).iterdir()]


@pytest.mark.parametrize("choice", sorted(CHOICES))
def test_it_runs_a_step(choice: str, tmp_path: Path) -> None:
    config = compose("train", [choice, *TINY], TrainJob).config()
    world = SyntheticConfig(rows=3, image_height=48, image_width=64, points=20, seed=1)
    result = train_source(config, SyntheticSource(world), tmp_path / "run")
    assert result.epochs == 1
    assert 0.0 < result.best_val_loss < 1.0
