"""Judging a run or an artefact: the same samples, the same figures."""

from pathlib import Path

from navtool.base.files import write_json
from navtool.export.artefact import open_artefact
from navtool.export.errors import ExportError
from navtool.export.manifest import MANIFEST
from navtool.train.config import Device
from navtool.train.device import torch_device
from navtool.train.errors import TrainError
from navtool.train.evaluate import EvaluationReport, Origin, evaluate_run, evaluate_scorer
from navtool.train.models import kind_of, read_config
from navtool.train.splits import Split


def evaluate_source(
    source: Path,
    dataset: Path | None,
    split: str = "test",
    out: Path | None = None,
    *,
    device: Device = Device.auto,
) -> EvaluationReport:
    """Judge whatever lies in a folder: a run, or an artefact, whose TorchScript model is then the one that is judged.

    Args:
        source: Folder of the run or artefact.
        dataset: Folder of the data set; None takes the one that a run was trained on. An artefact does not know it.
        split: train, val, test or all.
        out: File for the report as JSON; None writes none.
        device: Where the network runs.

    Raises:
        NavtoolError: Of the package whose input is at fault.
    """
    if split not in Split.__members__:
        known = ", ".join(Split.__members__)
        raise TrainError(f"there is no split {split!r}", where="split", cure=f"use one of {known}")
    if not (source / MANIFEST).is_file():
        return evaluate_run(source, dataset, Split[split], out, device=device)
    report = evaluate_artefact(source, dataset, Split[split], device=device)
    if out is not None:
        write_json(out, report.to_json())
    return report


def evaluate_artefact(
    artefact: Path, dataset: Path | None, split: Split = Split.test, *, device: Device = Device.auto
) -> EvaluationReport:
    """Judge an artefact's model; its files are checked against the manifest first.

    Raises:
        ExportError: The artefact cannot be trusted, or no data set is named.
    """
    opened = open_artefact(artefact)
    if dataset is None:
        raise ExportError("an artefact does not know where its data set is", where=artefact, cure="name it with --data")
    try:
        config = read_config(opened.manifest.kind, opened.manifest.config, where=artefact / MANIFEST)
    except TrainError as error:
        raise ExportError(error.what, where=artefact / MANIFEST, cure="use the navtool that wrote it") from error
    place = torch_device(device)
    origin = Origin(artefact.as_posix(), "artefact", config, opened.manifest.lineage)
    source = kind_of(config.model).task.open(dataset)
    return evaluate_scorer(opened.load(place), source, split, origin=origin, device=place)
