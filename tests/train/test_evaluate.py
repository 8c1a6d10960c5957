"""Judging a network: the right samples, honest about training data, plain JSON."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from noted import noted
from torch import Tensor

from navtool.base.plain import plain
from navtool.pipeline.success_metrics import SuccessMetrics, success_metrics
from navtool.train.config import Device, TrainConfig
from navtool.train.device import torch_device
from navtool.train.errors import TrainError
from navtool.train.evaluate import EvaluationReport, Origin, evaluate_scorer
from navtool.train.run_lineage import run_lineage
from navtool.train.splits import Split, split_episodes
from navtool.train.success.windows import plan_windows
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

CPU = torch.device("cpu")


def scorer(image: Tensor, points: Tensor, count: Tensor, velocity: Tensor, trajectory: Tensor, r: Tensor) -> Tensor:
    """A stand-in for a network: bright pictures promise success. Its figures can be worked out by hand."""
    del points, count, velocity, trajectory, r
    return (image.float().mean(dim=(1, 2, 3)) / 255.0)[:, None].expand(-1, 10)


def judge(
    source: SyntheticSource, config: TrainConfig, split: Split, lineage: dict[str, Any] | None = None
) -> EvaluationReport:
    known = lineage if lineage is not None else lineage_of(source, config)
    return evaluate_scorer(scorer, source, split, origin=Origin("run", "run", config, known), device=CPU)


def lineage_of(source: SyntheticSource, config: TrainConfig) -> dict[str, Any]:
    return run_lineage(config, source, split_episodes(source.episodes, config.split), {})


def test_the_figures_are_those_of_the_splits_samples(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    source = SyntheticSource(small_world)
    report = judge(source, small_config, Split.val)
    windows = plan_windows(source, [1], small_config.data)
    p = np.array([source.image(row).mean() / 255.0 for row in windows.row], dtype=np.float32)
    expected = success_metrics(np.repeat(p[:, None], 10, axis=1), windows.target, windows.known, small_config.metrics)
    assert isinstance(report.metrics, SuccessMetrics)
    assert report.metrics.trajectory.negatives == expected.trajectory.negatives == windows.report.negatives
    assert report.metrics.trajectory.fpr == expected.trajectory.fpr
    assert report.metrics.steps.brier == pytest.approx(expected.steps.brier, abs=1e-6)
    assert report.loss == pytest.approx(report.metrics.steps.brier, abs=1e-6)
    assert report.trained_on == 0


def test_all_says_how_much_was_trained_on(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    report = judge(SyntheticSource(small_world), small_config, Split.all)
    assert (report.windows.samples, report.trained_on) == (36, 12)


def test_a_report_is_plain_json(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    content = judge(SyntheticSource(small_world), small_config, Split.test).to_json()
    assert json.loads(json.dumps(content, allow_nan=False)) == content
    assert len(content["metrics"]["per_step"]) == 10
    assert content["metrics"]["trajectory"]["average_precision"] is None  # the test split has no positives


def test_another_data_set_is_refused_but_for_all(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    known = lineage_of(SyntheticSource(small_world), small_config)
    elsewhere = SyntheticSource(SyntheticConfig(places=["moor", "hill"], rows=12, image_height=48, image_width=64))
    with pytest.raises(TrainError, match=r"moor_0\.bag|no such episode"):
        judge(elsewhere, small_config, Split.test, known)
    report = judge(elsewhere, small_config, Split.all, known)
    assert (report.windows.samples, report.trained_on) == (24, 0)


def test_a_data_set_that_has_grown_keeps_its_split(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    known = lineage_of(SyntheticSource(small_world), small_config)
    grown = SyntheticSource(
        SyntheticConfig(places=["field", "park", "wood", "moor"], rows=12, image_height=48, image_width=64)
    )
    assert judge(grown, small_config, Split.val, known).windows.samples == 12


def test_a_split_without_samples_says_why(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    source = SyntheticSource(small_world)
    source.columns["valid.lidar"] = np.zeros(len(source), dtype=np.bool_)
    with pytest.raises(TrainError, match=r"no samples in 12 rows \(12 no_cloud\)"):
        judge(source, small_config, Split.val)


def test_without_a_test_split_another_one_is_judged(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    source = SyntheticSource(small_world)
    config = replace(small_config, split=replace(small_config.split, test_fraction=0.0, test_places=[]))
    with pytest.raises(TrainError, match="no recordings for the test split") as caught:
        judge(source, config, Split.test)
    assert "--split val" in str(caught.value.cure)
    assert judge(source, config, Split.val).samples > 0


@pytest.mark.parametrize(("says", "code"), [(0.9, "judged.always-success"), (0.1, "judged.always-failure")])
def test_a_constant_is_told(small_config: TrainConfig, small_world: SyntheticConfig, says: float, code: str) -> None:
    def constant(image: Tensor, *_: Tensor) -> Tensor:
        return torch.full((len(image), 10), says)

    source = SyntheticSource(small_world)
    origin = Origin("run", "run", small_config, lineage_of(source, small_config))
    report = evaluate_scorer(constant, source, Split.val, origin=origin, device=CPU)
    (told,) = noted(report.notes, code)
    assert "of every trajectory" in told
    assert report.to_json()["notes"] == [told]
    assert not judge(source, small_config, Split.val).notes, "one that tells them apart is no constant"


def test_a_damaged_lineage_is_named(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    with pytest.raises(TrainError, match="holds no split"):
        judge(SyntheticSource(small_world), small_config, Split.val, {"split": {"train": 3}})


def test_a_device_that_is_not_there_is_refused() -> None:
    if torch.cuda.is_available():
        pytest.skip("this machine has a GPU")
    with pytest.raises(TrainError, match="no cuda device"):
        torch_device(Device.cuda)
    assert torch_device(Device.cpu) == CPU


def test_lineage_is_a_function_of_its_inputs(small_config: TrainConfig, small_world: SyntheticConfig) -> None:
    one, other = (lineage_of(SyntheticSource(small_world), small_config) for _ in range(2))
    assert one == other == plain(one)
