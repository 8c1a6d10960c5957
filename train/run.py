"""A training run from a data set to a folder with checkpoints, figures and lineage."""

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import torch
from torch import nn

from navtool.base.progress import Progress
from navtool.train.checkpoint import checkpoint_stamp, load_run
from navtool.train.config import TrainConfig
from navtool.train.datamodule import RunData
from navtool.train.device import torch_device
from navtool.train.evaluate import EvaluationReport, Origin, evaluate_scorer
from navtool.train.fit import fit
from navtool.train.models import kind_of
from navtool.train.module import NetworkModule
from navtool.train.perf_monitor import PerfMonitor
from navtool.train.resume import first_epoch
from navtool.train.run_checkpoint import RunCheckpoint
from navtool.train.run_folder import RUN_SCHEMA, RunFolder
from navtool.train.run_lineage import check_same_data, dataset_path, run_lineage
from navtool.train.samples import SampleReport
from navtool.train.seeding import seed_torch
from navtool.train.source import Source
from navtool.train.splits import Split, split_episodes
from navtool.train.task import Remarks


@dataclass(frozen=True, slots=True)
class RunResult:
    """A finished run."""

    run: Path
    """The run's folder."""
    best_val_loss: float
    """Smallest loss on the validation split."""
    best_epoch: int
    """Epoch of it, counted from 0."""
    epochs: int
    """Epochs trained, those before a resume included."""
    seconds: float
    """Duration of this call."""
    samples_per_s: float
    """Training samples a second, validation not counted; 0 where nothing was left to train."""
    data_wait_share: float
    """Share of the training time spent waiting for data."""
    samples: dict[str, SampleReport]
    """Counts of each split."""
    remarks: Remarks
    """What the model's task says about the training samples."""


def train(
    config: TrainConfig, dataset: Path, out: Path, *, resume: bool = False, progress: Progress | None = None
) -> RunResult:
    """Train a network and leave a run folder.

    On one CPU the weights are a function of data set, configuration and code, and a run that was stopped and resumed
    ends with the same bits as one that was not.

    Args:
        config: The run's configuration.
        dataset: Folder of the data; for most models a data set that ``navtool ingest`` wrote and ``navtool label``
            labelled.
        out: The run's folder; must not hold another run.
        resume: Go on from the last whole epoch of the run in ``out``; begin it where there is none.
        progress: Learns how far it is.

    Raises:
        TrainError: The run cannot be begun, resumed or finished; the message names the cure.
        DatasetsError: The data set cannot be read.
    """
    return train_source(config, kind_of(config.model).task.open(dataset), out, resume=resume, progress=progress)


def resume(run: Path, *, progress: Progress | None = None) -> RunResult:
    """Go on with a run as it was configured, on the data set that it began with.

    Raises:
        TrainError: There is no run in the folder, or it cannot go on.
        DatasetsError: Its data set cannot be read any more.
    """
    folder = RunFolder(run)
    config = folder.read_config()
    return train(config, dataset_path(folder.read_lineage(), folder.lineage), run, resume=True, progress=progress)


def train_source(
    config: TrainConfig, source: Source, out: Path, *, resume: bool = False, progress: Progress | None = None
) -> RunResult:
    """`train` on any source that offers what the model's task needs."""
    begin = time.perf_counter()
    device = torch_device(config.trainer.device)
    folder = RunFolder(out)
    epoch = first_epoch(folder, config, resume=resume)
    splits = split_episodes(source.episodes, config.split)
    data = RunData(source, splits, config, first_epoch=epoch)
    lineage = run_lineage(config, source, splits, data.reports)
    if epoch:
        check_same_data(folder.read_lineage(), lineage)
    module = NetworkModule(_network(config), config)
    folder.write_config(config)
    folder.write_lineage(lineage)

    perf, checkpoints = PerfMonitor(), RunCheckpoint(folder.checkpoints, checkpoint_stamp(config))
    fit(config, folder, module, data, [perf, checkpoints], device=device, resume=epoch > 0, progress=progress)
    judged = {
        split.value: _judge(folder, source, split, device)
        for split in (Split.val, Split.test)
        if splits.episodes(split)
    }
    remarks = kind_of(config.model).task.remarks
    result = RunResult(
        run=out,
        best_val_loss=checkpoints.best_loss,
        best_epoch=checkpoints.best_epoch,
        epochs=max(epoch, config.trainer.epochs),
        seconds=time.perf_counter() - begin,
        samples_per_s=perf.samples / perf.train_s if perf.train_s else 0.0,
        data_wait_share=perf.wait_s / perf.train_s if perf.train_s else 0.0,
        samples={split.value: report for split, report in data.reports.items()},
        remarks=Remarks() if remarks is None else remarks(data.samples[Split.train]),
    )
    folder.write_metrics(_metrics(result, judged, device))
    return result


def _network(config: TrainConfig) -> nn.Module:
    """The network with the weights that the seed draws."""
    kind = kind_of(config.model)
    seed_torch(config.seed, 0)
    model: nn.Module = kind.build(config.model)
    if kind.begin is not None:
        kind.begin(model)
    return model


def _judge(folder: RunFolder, source: Source, split: Split, device: torch.device) -> EvaluationReport:
    """Judge the best checkpoint, as ``navtool evaluate`` would."""
    loaded = load_run(folder.path)
    origin = Origin(folder.path.as_posix(), "run", loaded.config, loaded.lineage)
    return evaluate_scorer(loaded.model.to(device), source, split, origin=origin, device=device)


def _metrics(result: RunResult, judged: Mapping[str, EvaluationReport], device: torch.device) -> dict[str, object]:
    """The content of ``metrics.json``."""
    return {
        "schema_version": RUN_SCHEMA,
        "epochs": result.epochs,
        "best_epoch": result.best_epoch,
        "best_val_loss": result.best_val_loss,
        "seconds": result.seconds,
        "samples_per_s": result.samples_per_s,
        "data_wait_share": result.data_wait_share,
        **result.remarks.figures,
        "device": device.type,
        "splits": {
            split: {
                "loss": report.loss,
                "metrics": report.metrics,
                "windows": report.windows,
                "notes": [note.text for note in report.judgement.notes],
            }
            for split, report in judged.items()
        },
    }
