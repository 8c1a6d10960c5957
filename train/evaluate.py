"""How well a trained network predicts on a split of a data set."""

import time
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, NamedTuple

import torch

from navtool.base.files import write_json
from navtool.base.lineage import plain
from navtool.datasets.store.reader import NavDataset
from navtool.pipeline.success_metrics import BinaryMetrics, SuccessMetrics, success_metrics
from navtool.train.checkpoint import load_run
from navtool.train.config import Device, TrainConfig
from navtool.train.datamodule import sample_loader
from navtool.train.device import torch_device
from navtool.train.errors import TrainError
from navtool.train.predictions import Scorer, predict
from navtool.train.run_folder import RunFolder
from navtool.train.run_lineage import dataset_path, splits_of
from navtool.train.samples import SampleDataset
from navtool.train.source import NavSource
from navtool.train.splits import Split
from navtool.train.windows import WindowReport, plan_windows

REPORT_SCHEMA = 1
"""Raised whenever the JSON form of a report changes its meaning."""


_FIGURES = tuple(entry.name for entry in fields(BinaryMetrics))


@dataclass(frozen=True, slots=True)
class EvaluationReport:
    """Figures of one network on one split."""

    source: str
    """Folder of the run or artefact."""
    kind: str
    """``run`` or ``artefact``."""
    split: str
    """train, val, test or all."""
    trained_on: int
    """Samples among those judged that the network was trained on; the figures say little about new places if any."""
    loss: float
    """Masked squared error."""
    metrics: SuccessMetrics
    """Rates, ranking and calibration: of trajectories, of steps and per horizon step."""
    windows: WindowReport
    """Counts of samples, positives and negatives, and of what was left out."""
    samples_per_s: float
    """Samples a second, reading included."""
    lineage: dict[str, Any]
    """What the network was made from."""

    @property
    def samples(self) -> int:
        """Number of samples judged."""
        return self.windows.samples

    def columns(self) -> tuple[str, ...]:
        """What the figures of a row of `rows` are of."""
        return ("trajectory", "all steps", *(f"t+{step}" for step in range(len(self.metrics.per_step))))

    def rows(self) -> tuple[tuple[str | float | None, ...], ...]:
        """One row a metric: its name, and its figure for each column; None where it is undefined."""
        judged = (self.metrics.trajectory, self.metrics.steps, *self.metrics.per_step)
        return tuple((name, *(getattr(part, name) for part in judged)) for name in _FIGURES)

    def to_json(self) -> dict[str, Any]:
        """Plain values; an undefined figure is null."""
        content = plain(self)
        return {"schema_version": REPORT_SCHEMA} | (content if isinstance(content, dict) else {})


def evaluate_run(
    run: Path,
    dataset: Path | None = None,
    split: Split = Split.test,
    out: Path | None = None,
    *,
    checkpoint: str = "best",
    device: Device = Device.auto,
) -> EvaluationReport:
    """Judge a run's network on a split, in float32.

    Args:
        run: The run's folder.
        dataset: The data set: the one that the run was trained on (None finds it), or any other with ``Split.all``.
        split: Which episodes.
        out: File for the report as JSON; None writes none.
        checkpoint: ``best`` or ``last``.
        device: Where the network runs.

    Raises:
        TrainError: The run cannot be used, or the split does not exist in this data set.
        DatasetsError: The data set cannot be read.
    """
    loaded = load_run(run, checkpoint)
    place = torch_device(device)
    model = loaded.model.to(place)
    where = dataset_path(loaded.lineage, RunFolder(run).lineage) if dataset is None else dataset
    report = evaluate_scorer(
        model,
        NavDataset(where),
        split,
        origin=Origin(run.as_posix(), "run", loaded.config, loaded.lineage),
        device=place,
    )
    if out is not None:
        write_json(out, report.to_json())
    return report


class Origin(NamedTuple):
    """Where a scorer comes from."""

    source: str
    """Folder of the run or artefact."""
    kind: str
    """``run`` or ``artefact``."""
    config: TrainConfig
    """What it was trained with: windows, batches and metrics follow it."""
    lineage: Mapping[str, Any]
    """What it was made from."""


def evaluate_scorer(
    score: Scorer,
    source: NavSource,
    split: Split,
    *,
    origin: Origin,
    device: torch.device,
) -> EvaluationReport:
    """Judge anything that scores samples; it must be in evaluation mode.

    Raises:
        TrainError: The split has no samples, or belongs to another data set.
    """
    config, lineage = origin.config, origin.lineage
    if split is Split.all:
        episodes = tuple(episode.index for episode in source.episodes)
    else:
        episodes = splits_of(lineage, source).episodes(split)
    windows = plan_windows(source, episodes, config.data)
    if not len(windows):
        reasons = ", ".join(f"{count} {reason}" for reason, count in windows.report.excluded.items() if count)
        raise TrainError(
            f"the {split.value} split has no samples in {windows.report.rows} rows ({reasons or 'no episodes'})",
            where="split",
            cure="choose another split, or label the data set",
        )
    loader = sample_loader(SampleDataset(source, windows, config.data), config.trainer.batch_size, workers=0)
    begin = time.perf_counter()
    predictions = predict(score, loader, device)
    seconds = time.perf_counter() - begin
    return EvaluationReport(
        source=origin.source,
        kind=origin.kind,
        split=split.value,
        trained_on=_trained_on(lineage, source, windows.episode.tolist()),
        loss=predictions.loss(),
        metrics=success_metrics(predictions.probability, predictions.target, predictions.known, config.metrics),
        windows=windows.report,
        samples_per_s=len(windows) / max(seconds, 1e-9),
        lineage=dict(lineage),
    )


def _trained_on(lineage: Mapping[str, Any], source: NavSource, episodes: list[int]) -> int:
    """Samples from recordings that the network was trained on."""
    trained = {str(entry["source"]) for entry in lineage.get("split", {}).get(Split.train.value, [])}
    return sum(source.episodes[index].source in trained for index in episodes)
