"""``navtool evaluate``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.train.evaluate import EvaluationReport


def evaluate(
    source: Path = typer.Argument(..., metavar="RUN|ARTEFACT", help="A training run, or an exported artefact."),
    data: Path | None = typer.Option(None, "--data", help="Folder of the data set; a run knows its own."),
    split: str = typer.Option("test", "--split", help="train, val, test or all."),
    out: Path | None = typer.Option(None, "--out", help="Write the report as JSON, into a folder that is there."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Judge a run or an artefact on a split.

    False positive and negative rates as GrASPE defines them, average precision, F1, Brier score and calibration error:
    of whole trajectories, and per step of the horizon.
    """
    from navtool.cli.arguments import require_folder_for, require_there
    from navtool.cli.compose import UsageError
    from navtool.cli.console import print_json
    from navtool.export.evaluate import evaluate_source
    from navtool.export.manifest import MANIFEST
    from navtool.train.splits import Split

    require_there(source, data)
    require_folder_for(out)
    if split not in Split.__members__:
        known = ", ".join(Split.__members__)
        raise UsageError(f"there is no split {split!r}", where="--split", cure=f"use one of {known}")
    if data is None and (source / MANIFEST).is_file():
        raise UsageError("an artefact does not know where its data set is", where=source, cure="name it with --data")
    report = evaluate_source(source, data, split, out)
    if as_json:
        print_json(report.to_json())
    else:
        print_evaluation(report)


def print_evaluation(report: "EvaluationReport") -> None:
    """The report for a person."""
    from navtool.cli.console import console, print_notes, print_table

    title, columns, rows = report.table
    print_table(f"{title} on {report.split}", ("metric", *columns), rows)
    print_notes(report.notes)
    console().print(f"{report.samples} samples of {report.source}; counts and lineage with --json", markup=False)
