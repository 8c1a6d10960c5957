"""``navtool compact``."""

from pathlib import Path

import typer


def compact(
    dataset: Path = typer.Argument(..., help="Folder of the data set.", show_default=False),
    out: Path = typer.Option(..., "--out", help="New folder for the copy.", show_default=False),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Copy a data set's rows and videos for LeRobot's streaming reader.

    All episodes are in one file of rows and one video a camera, which StreamingLeRobotDataset needs. What lies beside
    the rows is not copied: edit and train from the data set itself.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.edit_report import print_edits
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.edit.compact import compact as edit
    from navtool.datasets.store.reader import NavDataset

    require_there(dataset)
    with WorkProgress("episodes") as progress:
        report = edit(NavDataset(dataset), out, progress)
    print_edits([report], as_json=as_json)
