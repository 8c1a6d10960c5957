"""``navtool merge``."""

from pathlib import Path

import typer


def merge(
    datasets: list[Path] = typer.Argument(..., help="Folders of the data sets.", show_default=False),
    out: Path = typer.Option(..., "--out", help="New folder for all of their episodes.", show_default=False),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Copy the episodes of several data sets into one.

    They were made with the same settings. Rows, videos, labels and all that lies beside the rows are kept.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.edit_report import print_edits
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.edit.assemble import together
    from navtool.datasets.store.reader import NavDataset

    require_there(*datasets)
    with WorkProgress("episodes") as progress:
        report = together([NavDataset(root) for root in datasets], out, progress)
    print_edits([report], as_json=as_json)
