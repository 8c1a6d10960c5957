"""``navtool fit``: estimators that are fitted, not trained."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.methods.intensity_map.fit_report import FitReport

fit = typer.Typer(
    name="fit",
    help="Fit thresholds and estimators to recordings.",
    no_args_is_help=True,
    rich_markup_mode=None,
)


@fit.callback()
def _fit() -> None:
    """Fit thresholds and estimators to recordings."""


@fit.command("intensity_threshold")
def intensity_threshold(
    arguments: list[str] | None = typer.Argument(
        None, metavar="INPUT... [KEY=VALUE]...", help="Recordings, or one data set; then overrides."
    ),
    out: Path | None = typer.Option(None, "--out", help="Folder of the settings and the picture; made."),
    truth: Path | None = typer.Option(
        None, "--truth", help="What stands there (docs/annotations.md); simulated recordings know it themselves."
    ),
    episode: int | None = typer.Option(None, "--episode", min=0, help="Of a data set, counted from 0."),
    robot: str | None = typer.Option(None, "--robot", help="Robot preset, or a file as `inspect --write-robot` saves."),
    cfg: str | None = typer.Option(None, "--cfg", help="Print the configuration (job), and do nothing else."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Find the intensity, and the heights, that separate solid things from what yields, where it is known what stands.

    Writes settings.yaml for `navtool intensity-map --settings`, and the ROC curves. Choose the preset of the sensor:
    sensor=vlp16, hdl64, robosense, hesai, livox, ouster or simulated.
    """
    from navtool.cli.console import print_json
    from navtool.cli.walking import WalkCall, walk
    from navtool.configs.intensity_threshold_job import IntensityThresholdJob
    from navtool.methods.intensity_map.fit_report import FitReport

    call = WalkCall(
        command="fit", arguments=arguments or [], out=out, truth=truth, episode=episode, robot=robot, cfg=cfg
    )
    report = walk(call, "intensity_threshold", IntensityThresholdJob, FitReport)
    if report is not None and as_json:
        print_json(report.to_json())
    elif report is not None:
        _print_fit(report)


def _print_fit(report: "FitReport") -> None:
    """The report for a person: what was tried, what to set, and where it lies."""
    from navtool.cli.console import console, print_notes, print_table

    columns = ("height_m", "ground_margin_m", "threshold", "solid above %", "others above %", "J", "area")
    rows = (
        (
            one.height_m,
            one.ground_margin_m,
            one.threshold,
            round(100 * one.true_positive_rate, 1),
            round(100 * one.false_positive_rate, 1),
            one.gain,
            one.area,
        )
        for one in report.tried
    )
    print_table("Heights, the best first", columns, rows)
    if report.skipped:
        print_table("Left out", ("clouds", "count"), report.skipped.items())
    print_notes(report.notes)
    if report.done_before:
        print_notes([f"{report.out}: this fit is there already, of the same inputs and settings"])
    counted = ", ".join(f"{number} {kind}" for kind, number in report.cells.items())
    chosen = " ".join(f"map.{name}={value:g}" for name, value in report.settings.items())
    console().print(f"{report.sweeps} sweeps, {counted} cells; {chosen}", markup=False)
    used = f"navtool intensity-map INPUT --settings {report.out}/settings.yaml"
    console().print(f"written: {report.out}/settings.yaml, roc.svg, lineage.json; use: {used}", markup=False)
