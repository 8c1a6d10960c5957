"""``navtool split``."""

from pathlib import Path

import typer


def split(
    dataset: Path = typer.Argument(..., help="Folder of the data set.", show_default=False),
    parts: list[str] = typer.Argument(
        ..., metavar="NAME=EPISODES...", help="Parts by name, such as train=0-7 test=8,9.", show_default=False
    ),
    out: Path = typer.Option(..., "--out", help="Folder in which each part gets one of its name.", show_default=False),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Copy parts of a data set as data sets of their own.

    Rows, videos, labels and all that lies beside the rows are kept; the data set itself is not touched.
    """
    from navtool.cli.arguments import require_there
    from navtool.cli.compose import UsageError
    from navtool.cli.edit_report import episode_numbers, print_edits
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.edit.assemble import in_parts
    from navtool.datasets.store.reader import NavDataset

    require_there(dataset)
    found = NavDataset(dataset)
    chosen: dict[str, list[int]] = {}
    for part in parts:
        name, equals, episodes = part.partition("=")
        if not equals or name in chosen or Path(name).name != name or name in ("", ".."):
            raise UsageError(f"{part!r} is no part", where="split", cure="name parts as train=0-7, each once")
        chosen[name] = episode_numbers(episodes, len(found.episodes))
    with WorkProgress("episodes") as progress:
        reports = in_parts(found, chosen, out, progress)
    print_edits(reports, as_json=as_json)
