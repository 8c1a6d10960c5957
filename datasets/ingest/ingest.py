"""Recordings in, data set out: the orchestrator of ingest."""

import resource
import time
from collections.abc import Collection, Sequence
from contextlib import nullcontext
from pathlib import Path

from navtool.base.errors import DatasetsError
from navtool.base.progress import Progress, Silent
from navtool.base.workers import make_workers
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.foreseen import foresee
from navtool.datasets.ingest.job import Job
from navtool.datasets.ingest.line import Line
from navtool.datasets.ingest.natural import expand
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.ingest.settings import refuse_other_sensors, refuse_other_settings
from navtool.datasets.ingest.work import work_of
from navtool.datasets.recording.identity import size_of
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.writer import open_store


def ingest(
    paths: Sequence[Path],
    out: Path,
    robot: RobotConfig,
    config: IngestConfig,
    *,
    workers: int = 1,
    dry_run: bool = False,
    allow_missing: bool = False,
    strict: bool = False,
    named: Collection[str] = (),
    progress: Progress | None = None,
) -> IngestReport:
    """Turn each recording into an episode of the data set at ``out``, in the natural order of their paths.

    An episode is in the data set whole, or it is not. Recordings that are there already (same bytes, same settings)
    are skipped; a recording that has changed since, or is read with another robot configuration, replaces its episode.
    A recording that cannot become an episode is quarantined with its reason and ends nothing else. The same recordings
    and settings give the same files, whatever the number of workers.

    Args:
        paths: Bag files, rosbag2 folders, or folders that hold such; searched for recordings to any depth.
        workers: Processes that read recordings, and portions of one recording, at the same time; 1 works in this one.
        allow_missing: Take recordings that lack streams of the data set; their rows are not valid there.
        strict: Refuse recordings of which a stream or a part cannot be read, instead of taking what is left.
        named: Streams whose topics the user named: a recording that has none of them is quarantined as well.
        dry_run: Read and plan everything for the data set at ``out`` as it is; write nothing and lock nothing.

    Raises:
        DatasetsError: If a path does not exist, the data set was made with another rate or schema or is being written,
            or it cannot be written.
    """
    if workers < 1:
        raise DatasetsError(f"{workers} workers", cure="use at least one")
    started = time.monotonic()
    progress = progress or Silent()
    recordings = [(path, work_of(size_of(path), dry_run=dry_run)) for path in expand(paths, config.merge)]
    report = IngestReport(str(out), dry_run)
    job = Job(
        robot=robot,
        config=config,
        dry_run=dry_run,
        allow_missing=allow_missing,
        strict=strict,
        named=frozenset(named),
    )
    ahead = 1 if workers == 1 else workers + 1
    progress.begin(len(recordings), sum(work.total for _, work in recordings))
    refuse_other_sensors(robot, config)
    with nullcontext(foresee(out)) if dry_run else open_store(out) as store:
        refuse_other_settings(store, config)
        report.episodes_before = store.episodes
        with make_workers(workers, progress.advance) as running:
            Line(store, recordings, job, report, running, ahead, progress).run()
    report.seconds = time.monotonic() - started
    report.peak_rss_mib = _peak_rss_mib()
    return report


def _peak_rss_mib() -> float:
    """Peak memory of this process or one of its children, whichever used most."""
    peaks = [resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return max(peaks) / 1024
