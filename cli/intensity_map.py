"""``navtool intensity-map``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.methods.intensity_map.report import MapReport


def intensity_map(
    arguments: list[str] | None = typer.Argument(
        None, metavar="INPUT [KEY=VALUE]...", help="A recording, a URL of one, or a data set; then overrides."
    ),
    out: Path | None = typer.Option(None, "--out", help="Folder of the maps; made."),
    settings: Path | None = typer.Option(
        None, "--settings", help="Settings that `fit intensity_threshold` wrote; overrides win over them."
    ),
    truth: Path | None = typer.Option(
        None, "--truth", help="What stands there (docs/annotations.md), to score the maps; simulated runs know it."
    ),
    episode: int | None = typer.Option(None, "--episode", min=0, help="Of a data set, counted from 0."),
    robot: str | None = typer.Option(None, "--robot", help="Robot preset, or a file as `inspect --write-robot` saves."),
    cfg: str | None = typer.Option(None, "--cfg", help="Print the configuration (job), and do nothing else."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Map what is solid, pliable and transparent around the robot from LiDAR intensities (MIM).

    Writes arrays, pictures, an MCAP with occupancy grids and grid maps, a video and a page. Choose the preset of the
    sensor: sensor=vlp16, hdl64, robosense, hesai, livox, ouster or simulated.
    """
    from navtool.cli.console import print_json
    from navtool.cli.walking import WalkCall, walk
    from navtool.configs.intensity_map_job import IntensityMapJob
    from navtool.methods.intensity_map.report import MapReport

    call = WalkCall(
        command="intensity-map",
        arguments=arguments or [],
        out=out,
        truth=truth,
        episode=episode,
        robot=robot,
        cfg=cfg,
        settings=settings,
    )
    report = walk(call, "intensity_map", IntensityMapJob, MapReport)
    if report is not None and as_json:
        print_json(report.to_json())
    elif report is not None:
        print_maps(report)


def print_maps(report: "MapReport") -> None:
    """The report for a person: what the maps show, what was left out, and where they lie."""
    from navtool.cli.console import console, print_notes, print_table

    maps = max(report.maps, 1)
    rows = ((name, report.maps_with[name], round(cells / maps)) for name, cells in report.cells.items())
    print_table("Cells", ("class", "maps with it", "cells a map"), rows)
    if report.scores:
        scored = ((name, score.precision, score.recall, score.f) for name, score in report.scores.items())
        print_table("Agreement with what stands there", ("cells", "precision", "recall", "F"), scored)
    left_out = [(f"clouds: {reason}", count) for reason, count in report.skipped.items()]
    left_out += [(f"points: {reason}", count) for reason, count in report.points_dropped.items()]
    if report.not_scored:
        left_out.append(("maps not scored: the robot's place is not known", report.not_scored))
    if left_out:
        print_table("Left out", ("what", "count"), left_out)
    print_notes(report.notes)
    if report.done_before:
        print_notes([f"{report.out}: these maps are there already, of the same input and settings"])
    made = f"{report.maps} maps of {report.clouds} clouds of {report.duration_s:.1f} s"
    speed = "" if report.maps_per_s is None else f", made in {report.seconds:.1f} s, {report.maps_per_s:.0f} a second"
    files = ", ".join(f"{count} {name}" for name, count in report.files.items() if count)
    console().print(f"{made}{speed}; written: {files}; look at {report.out}/index.html", markup=False)
