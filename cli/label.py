"""``navtool label``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.datasets.labels.report import LabelReport


def label(
    dataset: str | None = typer.Argument(None, help="Folder of the data set."),
    overrides: list[str] | None = typer.Argument(None, metavar="[KEY=VALUE]...", help="Overrides of the rules."),
    events: Path | None = typer.Option(None, "--events", help="CSV or JSON: bag, start, end, outcome, reason."),
    cfg: str | None = typer.Option(None, "--cfg", help="Print the configuration (job), and do nothing else."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Label every row with its outcome.

    Rules look at the robot's own signals for collisions, standstills, falls and interventions; an events file
    overrides them. All labels change in one step, however often it is run.
    """
    from navtool.cli.arguments import require_there, split_overrides
    from navtool.cli.compose import UsageError, compose, print_config
    from navtool.cli.console import print_json
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.labels.apply import label_dataset
    from navtool.datasets.labels.config import LabelConfig

    given = [*([] if dataset is None else [dataset]), *(overrides or [])]
    folders, settings = split_overrides(given)
    config = compose("label", settings, LabelConfig)
    if cfg is not None:
        print_config(config, cfg)
        return
    if len(folders) != 1:
        raise UsageError(f"{len(folders)} data sets were named", where="label", cure="name one folder")
    root = Path(folders[0])
    require_there(root, events)
    with WorkProgress("episodes") as progress:
        report = label_dataset(root, config, events, progress=progress)
    if as_json:
        print_json(report.to_json())
    else:
        print_labels(report, root)


def print_labels(report: "LabelReport", dataset: Path) -> None:
    """The report for a person."""
    from navtool.cli.console import console, print_notes, print_table

    table = [("failed", report.failed_rows), ("negative samples", report.negatives), *sorted(report.reasons.items())]
    print_table("Labelled rows", ("what", "rows"), table)
    print_notes(
        f"rule {rule}: not applicable to {len(episodes)} of {report.episodes} episodes: {reason}"
        for rule, found in report.rules.items()
        for reason, episodes in found.not_applicable.items()
    )
    print_notes(report.notes)
    known = report.known_steps / report.all_steps
    done = f"{report.rows} rows in {report.episodes} episodes, {known:.0%} of the predicted steps known"
    console().print(f"{done}; {len(report.rewritten)} episodes rewritten; data set: {dataset}", markup=False)
