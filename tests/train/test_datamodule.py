"""Batches: complete, in an order that (seed, epoch) decides, and the same from worker processes."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from navtool.train.config import TrainConfig, TrainerConfig
from navtool.train.datamodule import RunData
from navtool.train.errors import TrainError
from navtool.train.graspe.config import GraspeConfig
from navtool.train.splits import Split, Splits
from navtool.train.success.windows import WindowReport
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

SPLITS = Splits(train=(0,), val=(1,), test=(2,))


def config(workers: int = 0) -> TrainConfig:
    return TrainConfig(
        model=GraspeConfig(image_height=48, image_width=64),
        trainer=TrainerConfig(batch_size=8, workers=workers),
        seed=3,
    )


def source() -> SyntheticSource:
    return SyntheticSource(SyntheticConfig(rows=30, image_height=48, image_width=64))


def module(settings: TrainConfig, data: SyntheticSource | None = None, first_epoch: int = 0) -> RunData:
    made = RunData(data or source(), SPLITS, settings, first_epoch=first_epoch)
    made.setup("fit")
    return made


def test_training_rows_are_those_of_their_split_in_shuffled_order() -> None:
    rows = torch.cat([batch.row for batch in module(config()).train_dataloader()]).tolist()
    assert sorted(rows) == list(range(30))
    assert rows != sorted(rows)


def test_validation_and_test_come_in_the_order_of_rows() -> None:
    made = module(config())
    assert torch.cat([batch.row for batch in made.val_dataloader()]).tolist() == list(range(30, 60))
    assert torch.cat([batch.row for batch in made.test_dataloader()]).tolist() == list(range(60, 90))


def test_a_resumed_run_begins_with_its_epochs_order() -> None:
    loader = module(config()).train_dataloader()
    loader.sampler.set_epoch(4)  # type: ignore[attr-defined]  # our own sampler
    resumed = module(config(), first_epoch=4).train_dataloader()
    for expected, got in zip(loader, resumed, strict=True):
        assert torch.equal(expected.row, got.row)


def test_worker_processes_give_the_same_batches() -> None:
    here = list(module(config()).train_dataloader())
    there = list(module(config(workers=1)).train_dataloader())
    for expected, got in zip(here, there, strict=True):
        assert all(torch.equal(a, b) for a, b in zip(expected, got, strict=True))


def test_the_reports_count_positives_and_negatives() -> None:
    report = module(config()).reports[Split.train]
    assert isinstance(report, WindowReport)
    assert report.samples == 30
    assert report.positives > 0
    assert report.negatives > 0


def test_unlabelled_data_say_how_to_label() -> None:
    data = source()
    data.columns["label.known"] = np.zeros((len(data), 10), dtype=np.bool_)
    with pytest.raises(TrainError, match=r"0 samples of 30 rows \(30 no_known_step\)") as caught:
        module(config(), data)
    assert caught.value.cure is not None
    assert "navtool label" in caught.value.cure


def test_another_image_size_names_the_settings() -> None:
    settings = replace(config(), model=GraspeConfig(image_height=240, image_width=64))
    with pytest.raises(TrainError, match="64x48 pixels") as caught:
        module(settings)
    assert caught.value.cure == "set model.image_width=64 and model.image_height=48"
