"""``navtool simulate``."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.sim.record.config import SimulationConfig
    from navtool.sim.record.episode import Episode
    from navtool.sim.record.report import SimulationReport


def simulate(
    overrides: list[str] | None = typer.Argument(
        None, metavar="[KEY=VALUE]...", help="Such as scenario=graspe_1 robot=quadruped drive.duration_s=60."
    ),
    out: Path | None = typer.Option(None, "--out", help="Folder of the recordings; made, or gone on with."),
    episodes: int = typer.Option(1, "--episodes", min=1, help="How many drives; those that are there count."),
    seed: int = typer.Option(0, "--seed", min=0, help="Decides places, drives and noise."),
    workers: int = typer.Option(1, "--workers", min=1, help="Processes that work at the same time."),
    preview: Path | None = typer.Option(None, "--preview", help="Draw one of the episodes as a contact sheet (PNG)."),
    cfg: str | None = typer.Option(None, "--cfg", help="Print the configuration (job), and do nothing else."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Drive robots through simulated places and record it, with ground truth.

    The bytes of a recording depend on scenario, settings, seed and its number alone. Run again, the command goes on
    with what is missing. Needs the extra sim.
    """
    from navtool.cli.compose import UsageError, print_config, wrong_call
    from navtool.cli.console import print_json
    from navtool.cli.extras import require_extra
    from navtool.sim.record.recordings import recordings_folder

    config = simulation_config(overrides or [])
    if cfg is not None:
        print_config(config, cfg)
        return
    if out is None:
        raise UsageError("no folder was named", where="simulate", cure="pass --out FOLDER")
    if preview is not None and preview.suffix != ".png":
        raise UsageError("is not the name of a PNG", where=preview, cure="end --preview in .png")
    require_extra("sim")
    with wrong_call():
        recordings_folder(out).refuse_other()
    report = run_simulation(config, out, episodes, seed, workers)
    if preview is not None:
        _draw(config, report, seed, preview)
    if as_json:
        print_json(report.to_json())
    else:
        print_simulation(report)
    if report.not_made:
        raise typer.Exit(1)


def simulation_config(overrides: Sequence[str]) -> "SimulationConfig":
    """The configuration that an override list gives.

    Raises:
        UsageError: There is no such scenario or robot, or another override is wrong.
    """
    from navtool.cli.compose import UsageError, compose, refuse_unknown_choices
    from navtool.sim.record.config import SimulationConfig
    from navtool.sim.record.rig import RobotKind

    robots = [override.removeprefix("robot=") for override in overrides if override.startswith("robot=")]
    others = [override for override in overrides if not override.startswith("robot=")]
    refuse_unknown_choices("scenario", others, "scenario")
    config = compose("simulate", others, SimulationConfig)
    for robot in robots:  # Hydra would take it for one of the presets of ingest
        if robot not in RobotKind.__members__:
            raise UsageError(f"no robot is called {robot!r}", cure=f"known are {', '.join(RobotKind.__members__)}")
        config.robot = RobotKind[robot]
    return config


def run_simulation(config: "SimulationConfig", out: Path, episodes: int, seed: int, workers: int) -> "SimulationReport":
    """Simulate with progress on the terminal."""
    from navtool.cli.progress import WorkProgress
    from navtool.sim.record.simulate import simulate as run

    with WorkProgress("episodes") as progress:
        return run(config, out, episodes, seed, workers=workers, progress=progress)


def _draw(config: "SimulationConfig", report: "SimulationReport", seed: int, preview: Path) -> None:
    """Draw the first new episode in which something went wrong; without any, the first one."""
    from navtool.base.files import write_bytes
    from navtool.cli.console import console
    from navtool.sim.record.preview import contact_sheet_png

    troubled = [episode.plan.number for episode in report.episodes if episode.failures]
    with console(error=True).status("drawing"):
        png = contact_sheet_png(config, seed, troubled[0] if troubled else 0)
    write_bytes(preview, png)


def print_simulation(report: "SimulationReport") -> None:
    """The report for a person: episodes, failures, and where they lie."""
    from navtool.cli.console import console, print_notes, print_table

    if report.episodes:
        columns = ("episode", "recording", "seconds", "failures", "failed %", "MB")
        print_table("Episodes", columns, map(_row, report.episodes))
    if report.not_made:
        rows = ((made.plan.number, made.plan.place, made.reason) for made in report.not_made)
        print_table("Not driven", ("episode", "place", "reason"), rows)
    if report.skipped:
        print_notes([f"{len(report.skipped)} episodes were there already, skipped"])
    print_notes(report.notes)
    if not report.episodes:
        console().print(f"nothing new; recordings: {report.folder}", markup=False)
        return
    failures = ", ".join(f"{n} {kind}" for kind, n in report.failures.items()) or "no failures"
    done = f"{len(report.episodes)} episodes, {report.minutes:.1f} minutes, {report.size_bytes / 1e6:.1f} MB"
    wrong = f"{failures} ({100 * report.failed_share:.0f} % of the time)"
    cost = f"{report.seconds:.1f} s, {report.pictures_per_s:.1f} pictures and clouds a second"
    memory = f"at most {report.peak_rss_mib:.0f} MiB of memory"
    console().print(f"{done}; {wrong}; {cost}, {memory}; recordings: {report.folder}", markup=False)


def _row(episode: "Episode") -> tuple[object, ...]:
    from collections import Counter

    failures = Counter(failure.kind.value for failure in episode.failures)
    return (
        episode.plan.number,
        episode.plan.path,
        round(episode.duration_s, 2),
        ", ".join(f"{count} {kind}" for kind, count in failures.items()),
        round(100 * episode.failed_share, 1),
        round(episode.size_bytes / 1e6, 1),
    )
