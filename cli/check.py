"""``navtool check``."""

from pathlib import Path

import typer


def check(
    dataset: Path = typer.Argument(..., help="Folder of the data set.", show_default=False),
    splits: Path | None = typer.Option(
        None, "--splits", help="File that names splits, such as a run's lineage.json: do they keep runs apart?"
    ),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Check a data set down to the last row.

    Also every video frame, footer and file beside it. The exit code is 1 if anything fails.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.console import console, print_json, print_table
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.check import check_dataset

    require_there(dataset, splits)
    with WorkProgress("checks") as progress:
        report = check_dataset(dataset, splits=splits, progress=progress)
    if as_json:
        print_json(report.to_json())
    else:
        if report.findings:
            print_table(
                "Findings",
                ("severity", "check", "where", "what"),
                ((f.severity.value, f.check, f.where, f.message) for f in report.findings),
            )
        if report.splits:
            print_table("Splits", ("split", "holds"), report.splits.items())
        fails = sum(finding.severity.value == "FAIL" for finding in report.findings)
        verdict = "passed" if report.passed else "FAILED"
        looked = f"{len(report.checks)} checks over {report.episodes} episodes, {report.rows} rows"
        console().print(f"{verdict}: {looked}; {fails} FAIL, {len(report.findings) - fails} WARN", markup=False)
    if not report.passed:
        raise typer.Exit(1)
