"""Recordings in, data set out: the orchestrator of ingest."""

import logging
import resource
import time
from collections import deque
from collections.abc import Sequence
from concurrent.futures import Future
from contextlib import nullcontext, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.progress import Progress, Silent
from navtool.base.workers import Workers, make_workers, outcome
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.foreseen import Foreseen, foresee
from navtool.datasets.ingest.natural import expand
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.report import EpisodeSummary, IngestReport, Quarantined
from navtool.datasets.ingest.segment import Segment, SegmentResult, cut_segments
from navtool.datasets.ingest.settings import refuse_other_contents, refuse_other_settings, settings_hash
from navtool.datasets.ingest.steps import (
    Joined,
    Planned,
    add_episode,
    foresee_episode,
    join_step,
    place_of,
    plan_step,
    segment_step,
)
from navtool.datasets.ingest.work import Work, work_of
from navtool.datasets.recording.identity import source_name
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.schema import Contents
from navtool.datasets.store.staged_episode import Numbering, discard
from navtool.datasets.store.writer import Store, open_store

logger = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """What every recording of a command is treated with."""

    robot: RobotConfig
    config: IngestConfig
    dry_run: bool = False
    allow_missing: bool = False

    @property
    def settings_hash(self) -> str:
        """Hash of what decides an episode's content."""
        return settings_hash(self.robot, self.config)


def ingest(
    paths: Sequence[Path],
    out: Path,
    robot: RobotConfig,
    config: IngestConfig,
    *,
    workers: int = 1,
    dry_run: bool = False,
    allow_missing: bool = False,
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
        dry_run: Read and plan everything for the data set at ``out`` as it is; write nothing and lock nothing.

    Raises:
        DatasetsError: If a path does not exist, the data set was made with another rate or schema or is being written,
            or it cannot be written.
    """
    if workers < 1:
        raise DatasetsError(f"{workers} workers", cure="use at least one")
    started = time.monotonic()
    watch = progress or Silent()
    recordings = expand(paths, config.merge)
    report = IngestReport(str(out), dry_run)
    job = Job(robot=robot, config=config, dry_run=dry_run, allow_missing=allow_missing)
    work = [work_of(size_of(path), dry_run=dry_run) for path in recordings]
    watch.begin(len(recordings), sum(each.total for each in work))
    with nullcontext(foresee(out)) if dry_run else open_store(out) as store:
        refuse_other_settings(store, config)
        report.episodes_before = store.episodes
        with make_workers(workers, watch.advance) as hands:
            _Line(store, list(zip(recordings, work, strict=True)), job, report, hands, workers, watch).run()
    report.seconds = time.monotonic() - started
    peaks = [resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    report.peak_rss_mib = max(peaks) / 1024
    return report


def size_of(path: Path) -> int:
    """Bytes of a recording, a file or a folder; what vanishes meanwhile counts nothing."""
    size = 0
    for file in [path] if path.is_file() else path.rglob("*"):
        with suppress(OSError):
            size += file.stat().st_size if file.is_file() else 0
    return size


@dataclass(slots=True)
class _Recording:
    """A recording under way."""

    number: int
    path: Path
    fixed: Contents | None
    """The contents that it was planned for."""
    planning: Future[Planned]
    written: bool
    """Whether an episode is to be written of it; not in a dry run."""
    work: Work
    unbegun: int
    """Units of its work that no step counts."""
    plan: Planned | None = None
    segments: list[Segment] = field(default_factory=list)
    reading: dict[Future[SegmentResult], int] = field(default_factory=dict)
    """Of each segment, with its work."""
    joining: Future[Joined] | None = None
    failed: DatasetsError | None = None

    @property
    def futures(self) -> list[Future[Any]]:
        """What is still to be waited for."""
        every: list[Future[Any]] = [self.planning, *self.reading, *([] if self.joining is None else [self.joining])]
        return [future for future in every if not future.done()]

    @property
    def to_join(self) -> EpisodePlan | None:
        """The plan of an episode that is read and not joined yet."""
        ready = self.written and self.failed is None and self.joining is None and not self.futures
        return self.plan.plan if ready and self.plan is not None else None

    @property
    def finished(self) -> bool:
        """Whether nothing more is to be done before it is concluded."""
        return not self.futures and (self.failed is not None or (self.plan is not None and self.to_join is None))


class _Line:
    """The recordings of a command on their way into the data set: read in any order, added in theirs."""

    def __init__(
        self,
        store: Store,
        recordings: Sequence[tuple[Path, Work]],
        job: Job,
        report: IngestReport,
        hands: Workers,
        workers: int,
        watch: Progress,
    ) -> None:
        self._store, self._job, self._report, self._hands, self._watch = store, job, report, hands, watch
        self._waiting = deque(enumerate(recordings))
        self._ahead = 1 if workers == 1 else workers + 1
        self._under_way: deque[_Recording] = deque()
        self._known = {str(entry["sha256"]): str(entry["config_hash"]) for entry in store.provenance()}
        self._done = 0

    def run(self) -> None:
        """Add every recording, or say why not."""
        while self._waiting or self._under_way:
            while self._waiting and len(self._under_way) < self._ahead and self._may_begin():
                number, (path, work) = self._waiting.popleft()
                self._under_way.append(self._begin(number, path, work))
            self._hands.wait([future for entry in self._under_way for future in entry.futures])
            for place, entry in enumerate(self._under_way):
                self._proceed(entry, place)
            while self._under_way and self._under_way[0].finished:
                self._conclude(self._under_way.popleft())
        self._hands.wait([])

    def _contents(self) -> Contents | None:
        """What the data set's rows have; as long as it is empty, what its first recording seems to make of it."""
        return None if self._store.description is None else self._store.description.contents

    def _may_begin(self) -> bool:
        """The first recording of a data set fixes what the others are read for."""
        return self._contents() is not None or not self._under_way or self._under_way[0].plan is not None

    def _begin(self, number: int, path: Path, work: Work) -> _Recording:
        fixed = self._contents()
        if fixed is None and self._under_way and self._under_way[0].plan is not None:
            head = self._under_way[0].plan.plan
            fixed = None if head is None else head.contents
        staged = None if self._job.dry_run else self._staged(number)
        known = frozenset(sha for sha, settings in self._known.items() if settings == self._job.settings_hash)
        job = self._job
        planning = self._hands.submit(work.planning, plan_step, path, job.robot, job.config, fixed, known, staged)
        unbegun = work.reading + work.joining
        return _Recording(number, path, fixed, planning, not job.dry_run, work, unbegun)

    def _staged(self, number: int) -> Path:
        return self._store.layout.staging / f"{number:06d}"

    def _proceed(self, entry: _Recording, ahead: int = 0) -> None:
        """Have a recording's segments read once it is planned, and joined once they are read; note what failed.

        Args:
            ahead: So many recordings stand before it in the line.
        """
        try:
            if entry.plan is None and entry.planning.done():
                entry.plan = outcome(entry.planning)
                if entry.plan.plan is not None:
                    self._have_read(entry, entry.plan.plan)
            for future in entry.reading:
                if future.done():
                    outcome(future)
            if entry.joining is not None and entry.joining.done():
                outcome(entry.joining)
            plan = entry.to_join
            if plan is not None:
                results = [future.result() for future in entry.reading]
                staged, place = self._staged(entry.number), self._likely_place(ahead)
                entry.unbegun -= entry.work.joining
                entry.joining = self._hands.submit(
                    entry.work.joining, join_step, plan, entry.segments, results, place, self._job.config, staged
                )
        except OutputError:
            raise
        except DatasetsError as error:
            entry.failed = error
            for future in list(entry.reading):
                if future.cancel():
                    entry.unbegun += entry.reading.pop(future)

    def _have_read(self, entry: _Recording, plan: EpisodePlan) -> None:
        if entry.fixed is not None:
            refuse_other_contents(entry.fixed, plan.found, allow_missing=self._job.allow_missing)
        if not entry.written:
            return
        entry.segments = cut_segments(plan)
        staged, ticks = self._staged(entry.number), int(plan.ticks_ns.size)
        for segment in entry.segments:
            work = entry.work.reading_of(segment, ticks)
            entry.unbegun -= work
            entry.reading[self._hands.submit(work, segment_step, entry.path, segment, self._job.config, staged)] = work

    def _likely_place(self, ahead: int) -> Numbering:
        """Where an episode will be if all that stand before it are added; where they are not, it is numbered again."""
        place = self._store.numbering(None)
        for entry in list(self._under_way)[:ahead]:
            if entry.plan is not None and entry.plan.plan is not None and entry.failed is None:
                rows = int(entry.plan.plan.ticks_ns.size)
                place = Numbering(place.episode_index + 1, place.index_from + rows)
        return place

    def _conclude(self, entry: _Recording) -> None:
        """The recording that is first in the line becomes an episode, or is left out with its reason."""
        try:
            summary = self._summary(entry)
        except OutputError:
            raise
        except DatasetsError as error:
            self._quarantine(entry.path, error)
        else:
            if summary is not None:
                self._report.episodes.append(summary)
        if entry.written:
            discard(self._staged(entry.number))
        self._watch.advance(0, entry.unbegun)
        self._done += 1
        self._watch.done(self._done, source_name(entry.path))

    def _summary(self, entry: _Recording) -> EpisodeSummary | None:
        if entry.fixed != self._contents():
            # It was read for contents that the data set has not got after all: the first recording failed.
            if entry.written:
                discard(self._staged(entry.number))
            # What was counted once is not counted again.
            again = self._begin(entry.number, entry.path, Work())
            while not again.finished:
                self._hands.wait(again.futures)
                self._proceed(again)
            entry = again
        if entry.failed is not None:
            raise entry.failed
        if entry.plan is None:
            raise ValueError("a recording that was not planned")
        self._report.bytes_in += 0 if entry.plan.plan is None else entry.plan.size
        if entry.plan.plan is None or self._known.get(entry.plan.sha256) == self._job.settings_hash:
            self._keep(entry)
            return None
        job = self._job
        if isinstance(self._store, Foreseen):
            summary = foresee_episode(self._store, entry.path, entry.plan, job.robot, job.config)
        elif entry.joining is None:
            raise ValueError("a recording that was not joined")
        else:
            summary = add_episode(self._store, entry.path, entry.plan, outcome(entry.joining), job.robot, job.config)
        self._known[entry.plan.sha256] = self._job.settings_hash
        return summary

    def _keep(self, entry: _Recording) -> None:
        """Leave an episode as it is; only its place is a name, which may be another one now."""
        name, place = source_name(entry.path), place_of(entry.path, self._job.config)
        self._report.skipped.append(name)
        if entry.plan is None or not place:
            return
        if self._store.set_place(entry.plan.sha256, place):
            self._report.placed[name] = place

    def _quarantine(self, path: Path, error: DatasetsError) -> None:
        logger.warning("%s", error)
        reason = error.what if error.where in (None, str(path)) else f"{error.where}: {error.what}"
        cured = reason if error.cure is None else f"{reason} ({error.cure})"
        self._report.quarantined.append(Quarantined(str(path), cured))
