"""How well a trained network predicts on a split of its data."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import torch

from navtool.base.files import write_json
from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.train.checkpoint import load_run
from navtool.train.config import Device, TrainConfig
from navtool.train.datamodule import sample_loader
from navtool.train.device import torch_device
from navtool.train.errors import TrainError
from navtool.train.judgement import Judgement, Table
from navtool.train.models import kind_of
from navtool.train.predict import predict
from navtool.train.run_folder import RunFolder
from navtool.train.run_lineage import dataset_path, splits_of
from navtool.train.samples import SampleReport
from navtool.train.source import Source
from navtool.train.splits import Split

REPORT_SCHEMA = 1
"""Raised whenever the JSON form of a report changes its meaning."""


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
    judgement: Judgement
    """Loss and metrics."""
    windows: SampleReport
    """Counts of samples, and of what was left out."""
    samples_per_s: float
    """Samples a second, reading included."""
    lineage: dict[str, Any]
    """What the network was made from."""

    @property
    def samples(self) -> int:
        """Number of samples judged."""
        return self.windows.samples

    @property
    def loss(self) -> float:
        """What training makes smaller."""
        return self.judgement.loss

    @property
    def metrics(self) -> object:
        """The task's own figures."""
        return self.judgement.metrics

    @property
    def notes(self) -> tuple[Note, ...]:
        """What the figures alone would hide."""
        learnt = f"{self.trained_on} of {self.samples} samples are of recordings that the model was trained on"
        seen = f"{learnt}: the figures say little of new places"
        told = () if self.split == Split.train or not self.trained_on else (Note("judged.trained-on", seen),)
        return (*self.judgement.notes, *told)

    @property
    def table(self) -> Table:
        """The figures for a person."""
        return self.judgement.table

    def to_json(self) -> dict[str, Any]:
        """Plain values; an undefined figure is null."""
        names = ("source", "kind", "split", "trained_on", "loss", "metrics", "windows", "samples_per_s", "lineage")
        content = {"schema_version": REPORT_SCHEMA} | {name: plain(getattr(self, name)) for name in names}
        return content | {"notes": [note.text for note in self.notes]}


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
        kind_of(loaded.config.model).task.open(where),
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
    """What it was trained with: samples, batches and metrics follow it."""
    lineage: Mapping[str, Any]
    """What it was made from."""


def evaluate_scorer(
    score: Callable[..., Any],
    source: Source,
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
    kind = kind_of(config.model)
    samples = kind.task.samples(source, episodes, config)
    if not episodes:
        cure = "judge another one, such as --split val"
        raise TrainError(f"the run kept no recordings for the {split.value} split", where="split", cure=cure)
    if not len(samples):
        reasons = samples.report.reasons() or "no episodes"
        raise TrainError(
            f"the {split.value} split has no samples in {samples.report.rows} rows ({reasons})",
            where="split",
            cure="choose another split, or label the data set",
        )
    loader = sample_loader(samples, config.trainer.batch_size, workers=0)
    begin = time.perf_counter()
    judge = kind.task.judge(config)
    for batch in loader:
        judge.add(batch, predict(score, kind.inputs(batch), device))
    judgement = judge.result()
    seconds = time.perf_counter() - begin
    return EvaluationReport(
        source=origin.source,
        kind=origin.kind,
        split=split.value,
        trained_on=_trained_on(lineage, source, samples.episode.tolist()),
        judgement=judgement,
        windows=samples.report,
        samples_per_s=len(samples) / max(seconds, 1e-9),
        lineage=dict(lineage),
    )


def _trained_on(lineage: Mapping[str, Any], source: Source, episodes: list[int]) -> int:
    """Samples from recordings that the network was trained on."""
    trained = {str(entry["source"]) for entry in lineage.get("split", {}).get(Split.train.value, [])}
    return sum(source.episodes[index].source in trained for index in episodes)
