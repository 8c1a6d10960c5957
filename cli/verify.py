"""``navtool verify``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.export.verify import VerifyReport


def verify(
    artefact: Path = typer.Argument(..., help="Folder of the artefact.", show_default=False),
    latency_runs: int = typer.Option(20, "--latency-runs", min=1, help="Runs to time."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Check that an artefact is what it says.

    Hashes, input and output contract, parity with the golden output, latency. The exit code is 1 on any mismatch.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.console import print_json
    from navtool.export.verify import verify as run

    require_there(artefact)
    report = run(artefact, latency_runs)
    if as_json:
        print_json(report.to_json())
    else:
        print_verification(report)
    if not report.passed:
        raise typer.Exit(1)


def print_verification(report: "VerifyReport") -> None:
    """The report for a person."""
    from navtool.cli.console import console, print_notes, print_table

    print_table("Verification", ("check", "ok", "detail"), ((c.name, c.ok, c.detail) for c in report.checks))
    print_notes(report.notes)
    console().print(f"{'verified' if report.passed else 'NOT VERIFIED'}: {report.artefact}", markup=False)
