"""``navtool delete``."""

from pathlib import Path

import typer


def delete(
    dataset: Path = typer.Argument(..., help="Folder of the data set.", show_default=False),
    episodes: str = typer.Argument(..., help="Episodes to leave out, such as 0,3-5.", show_default=False),
    out: Path = typer.Option(..., "--out", help="New folder for the data set without them.", show_default=False),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Copy a data set without some of its episodes.

    Rows, videos, labels and all that lies beside the rows are kept; the data set itself is not touched.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.edit_report import episode_numbers, print_edits
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.edit.assemble import without_episodes
    from navtool.datasets.store.reader import NavDataset

    require_there(dataset)
    found = NavDataset(dataset)
    numbers = episode_numbers(episodes, len(found.episodes))
    with WorkProgress("episodes") as progress:
        report = without_episodes(found, numbers, out, progress)
    print_edits([report], as_json=as_json)
