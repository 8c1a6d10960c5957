"""``navtool migrate``."""

from pathlib import Path

import typer


def migrate(
    dataset: Path = typer.Argument(..., help="Folder of a data set of an older schema version.", show_default=False),
    out: Path = typer.Option(..., "--out", help="New folder for the copy.", show_default=False),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Copy a data set of the schema version before in this one's form.

    Nothing is computed or encoded again; the old data set is not touched. Stopped at any moment, there is no copy.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.edit_report import print_edits
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.edit.migrate import migrate as edit

    require_there(dataset)
    with WorkProgress("episodes") as progress:
        report = edit(dataset, out, progress)
    print_edits([report], as_json=as_json)
