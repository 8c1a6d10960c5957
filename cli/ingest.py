"""``navtool ingest``."""

from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from navtool.datasets.ingest.report import IngestReport, Quarantined

_NAMED = 5
"""Recordings that are named under a reason before the rest is counted; all are in the JSON report."""


def ingest(
    arguments: list[str] | None = typer.Argument(
        None, metavar="BAG... [KEY=VALUE]...", help="Recordings, folders, patterns or URLs of them; then overrides."
    ),
    out: Path | None = typer.Option(None, "--out", help="Folder of the data set; made, or appended to."),
    robot: str | None = typer.Option(None, "--robot", help="Robot preset, or a file as `inspect --write-robot` saves."),
    workers: int = typer.Option(1, "--workers", min=1, help="Processes that read at the same time."),
    dry_run: bool = typer.Option(
        False, "--dry-run", help="Read and plan for the data set at --out as it is; write nothing."
    ),
    allow_missing: bool = typer.Option(
        False, "--allow-missing", help="Take recordings that lack streams or named topics."
    ),
    strict: bool = typer.Option(False, "--strict", help="Refuse recordings that cannot be read whole."),
    cfg: str | None = typer.Option(None, "--cfg", help="Print the configuration (job), and do nothing else."),
    as_json: bool = typer.Option(False, "--json", help="Print JSON."),
) -> None:
    """Turn recordings into a data set (LeRobot v3).

    Each recording becomes one episode. Recordings that are in the data set already are skipped; one that cannot become
    an episode is reported with its reason, and the exit code is then 1.
    """
    from navtool.cli.arguments import split_overrides
    from navtool.cli.compose import UsageError, print_config, wrong_call
    from navtool.cli.console import print_json
    from navtool.cli.progress import WorkProgress
    from navtool.cli.robots import ingest_job, named_streams
    from navtool.datasets.ingest.ingest import ingest as run
    from navtool.datasets.ingest.settings import refuse_other_sensors
    from navtool.datasets.store.writer import data_set_folder

    paths, overrides = split_overrides(arguments or [])
    job = ingest_job(robot, overrides)
    if cfg is not None:
        print_config(job, cfg)
        return
    if not paths:
        raise UsageError("no recording was named", where="ingest", cure="name bag files, or folders of them")
    if out is None:
        raise UsageError("no data set was named", where="ingest", cure="pass --out FOLDER")
    with wrong_call():
        refuse_other_sensors(job.robot, job.config())
        data_set_folder(out).refuse_other()
    recordings = _recordings(paths)
    with WorkProgress("recordings") as progress:
        report = run(
            recordings,
            out,
            job.robot,
            job.config(),
            workers=workers,
            dry_run=dry_run,
            allow_missing=allow_missing,
            strict=strict,
            named=named_streams(robot, overrides, job.robot),
            progress=progress,
        )
    if as_json:
        print_json(report.to_json())
    else:
        print_ingest(report)
    if report.quarantined:
        raise typer.Exit(1)


def _recordings(named: list[str]) -> list[Path]:
    """Where the recordings lie that are named; those that are URLs are fetched once the others are there."""
    from navtool.cli.arguments import require_there
    from navtool.cli.compose import wrong_call
    from navtool.cli.progress import WorkProgress
    from navtool.datasets.recording.remote import default_cache, is_url, local_paths

    with wrong_call():
        require_there(*local_paths([text for text in named if not is_url(text)], default_cache()))
    with WorkProgress("files fetched") as progress:
        return local_paths(named, default_cache(), progress)


def print_ingest(report: "IngestReport") -> None:
    """The report for a person: episodes, what was left out and why, and where the data set lies."""
    from navtool.cli.console import print_notes, print_table

    if report.episodes:
        print_table(
            "Episodes (planned, nothing written)" if report.dry_run else "Episodes",
            ("episode", "recording", "rows", "streams"),
            (
                (e.episode, e.source, e.rows, ", ".join(f"{s} {t}" for s, t in e.topics.items()))
                for e in report.episodes
            ),
        )
    if report.dropped:
        print_table("Messages without a row", ("reason", "messages"), report.dropped.items())
    unused = {(t["name"], t["type"], t["reason"]) for e in report.episodes for t in e.not_used}
    if unused:
        print_table("Topics not used", ("topic", "type", "reason"), sorted(unused))
    if report.quarantined:
        _print_quarantined(report.quarantined)
    if len(report.episodes) == 1:
        print_notes(report.episodes[0].notes)
    else:
        print_notes(note.about(e.source) for e in report.episodes for note in e.notes)
    print_notes(f"{source}: in the data set already, skipped" for source in report.skipped)
    now = "would be" if report.dry_run else "is now"
    print_notes(f"{source}: its place {now} {place}" for source, place in report.placed.items())
    _print_total(report)


def _print_total(report: "IngestReport") -> None:
    from navtool.cli.console import console

    done = f"{len(report.episodes)} episodes, {report.rows} rows from {report.bytes_in / 1e6:.1f} MB"
    cost = f"{report.seconds:.1f} s, at most {report.peak_rss_mib:.0f} MiB of memory"
    where = f"data set: {report.dataset}" if Path(report.dataset).is_dir() else "nothing written"
    if report.dry_run:
        there = f"the {report.episodes_before} episodes of" if report.episodes_before else "a new data set at"
        where = f"planned for {there} {report.dataset}, nothing written"
    console().print(f"{done} in {cost}; {where}", markup=False)


def _print_quarantined(quarantined: "list[Quarantined]") -> None:
    """What gave no episode: each reason once, with its recordings."""
    from navtool.cli.console import print_table

    paths: dict[str, list[str]] = {}
    for entry in quarantined:
        paths.setdefault(entry.reason, []).append(entry.path)
    rows = []
    for reason, found in paths.items():
        more = [f"and {len(found) - _NAMED} more, see --json"] if len(found) > _NAMED else []
        rows.append((len(found), reason, "\n".join([*found[:_NAMED], *more])))
    print_table("Not ingested", ("count", "reason", "recordings"), rows)
