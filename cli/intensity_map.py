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
    from navtool.base.output_folder import OutputFolder
    from navtool.cli.arguments import local_path, require_there, split_overrides
    from navtool.cli.compose import UsageError, print_config, refuse_unknown_choices, wrong_call
    from navtool.cli.console import print_json
    from navtool.cli.progress import WorkProgress
    from navtool.cli.robots import job_with_robot
    from navtool.cli.settings_file import settings_overrides
    from navtool.configs.intensity_map_job import IntensityMapJob
    from navtool.datasets.ingest.config import Merge
    from navtool.methods.along.source import MapInput
    from navtool.methods.intensity_map.run import KIND, intensity_maps

    inputs, overrides = split_overrides(arguments or [])
    refuse_unknown_choices("sensor", overrides, "sensor preset")
    if settings is not None and any(override.startswith("sensor=") for override in overrides):
        cure = "leave sensor= out: the settings hold the scale of the sensor that they were fitted to"
        raise UsageError("--settings and sensor= both name a sensor", where="intensity-map", cure=cure)
    job = job_with_robot("intensity_map", robot, [*settings_overrides(settings), *overrides], IntensityMapJob)
    if cfg is not None:
        print_config(job, cfg)
        return
    if len(inputs) != 1:
        named = "no recording or data set was named" if not inputs else f"{len(inputs)} inputs were named"
        raise UsageError(named, where="intensity-map", cure="name one recording, or one data set")
    if out is None:
        raise UsageError("no folder was named", where="intensity-map", cure="pass --out FOLDER")
    require_there(truth)
    with wrong_call():
        OutputFolder(out, KIND).refuse_other()
    chosen = MapInput(local_path(inputs[0]), episode, job.robot, job.merge is Merge.folder)
    count = chosen.episode_count()
    with wrong_call():
        chosen.refuse_episode(count)
    if count is not None and (robot is not None or any(x.startswith("robot") for x in overrides)):
        raise UsageError("the data set knows its own robot", where=chosen.path, cure="leave --robot and robot. out")
    with WorkProgress("runs") as progress:
        report = intensity_maps(chosen, out, job.config(), progress, truth)
    if as_json:
        print_json(report.to_json())
    else:
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
