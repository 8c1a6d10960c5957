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
    out: Path | None = typer.Option(None, "--out", help="Where to write the JSON report."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Judge a run or an artefact on a split.

    False positive and negative rates as GrASPE defines them, average precision, F1, Brier score and calibration error:
    of whole trajectories, and per step of the horizon.
    """
    from navtool.cli.console import print_json
    from navtool.export.evaluate import evaluate_source

    report = evaluate_source(source, data, split, out)
    if as_json:
        print_json(report.to_json())
    else:
        print_evaluation(report)


def print_evaluation(report: "EvaluationReport") -> None:
    """The report for a person."""
    from navtool.cli.console import console, print_table

    print_table(f"Success prediction on {report.split}", ("metric", *report.columns()), report.rows())
    console().print(f"{report.samples} samples of {report.source}; counts and lineage with --json", markup=False)
