"""The recordings of a command on their way into the data set: read in any order, added in theirs."""

import logging
from collections import deque
from collections.abc import Sequence
from pathlib import Path

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.progress import Progress
from navtool.base.workers import Workers
from navtool.datasets.ingest.add_episode import add_episode, foresee_episode
from navtool.datasets.ingest.candidate import Candidate
from navtool.datasets.ingest.foreseen import Foreseen
from navtool.datasets.ingest.job import Job
from navtool.datasets.ingest.join_step import Joined
from navtool.datasets.ingest.phase import Failed, Kept, Ready
from navtool.datasets.ingest.plan_step import Planned
from navtool.datasets.ingest.provenance import place_of
from navtool.datasets.ingest.report import EpisodeSummary, IngestReport, Quarantined
from navtool.datasets.ingest.work import Work
from navtool.datasets.recording.identity import source_name
from navtool.datasets.store.schema import Contents
from navtool.datasets.store.staged_episode import Numbering, discard
from navtool.datasets.store.writer import Store

logger = logging.getLogger(__name__)


class Line:
    """Recordings that wait, those under way, and the data set that they are added to.

    Args:
        recordings: In the order of their episodes, each with its expected work.
        report: What becomes of each is written into it.
        ahead: Recordings that may be under way at a time.
    """

    def __init__(
        self,
        store: Store,
        recordings: Sequence[tuple[Path, Work]],
        job: Job,
        report: IngestReport,
        workers: Workers,
        ahead: int,
        progress: Progress,
    ) -> None:
        self._store, self._job, self._report = store, job, report
        self._workers, self._ahead, self._progress = workers, ahead, progress
        self._waiting = deque(recordings)
        self._under_way: deque[Candidate] = deque()
        self._known = {str(entry["sha256"]): str(entry["config_hash"]) for entry in store.provenance()}
        self._begun = 0
        self._concluded = 0

    def run(self) -> None:
        """Add every recording, or say why not."""
        while self._waiting or self._under_way:
            while self._may_begin():
                self._begin_next()
            self._workers.wait([future for candidate in self._under_way for future in candidate.awaited])
            for position, candidate in enumerate(self._under_way):
                candidate.proceed(self._expected_numbering(position))
            while self._under_way and self._under_way[0].ended:
                self._end(self._under_way.popleft())
        self._workers.wait([])

    def _contents(self) -> Contents | None:
        """What the data set's rows have; None as long as it is empty."""
        return None if self._store.description is None else self._store.description.contents

    def _expected_contents(self) -> Contents | None:
        """What the data set's rows will have if the first recording under way becomes an episode."""
        plan = self._under_way[0].plan if self._under_way else None
        return self._contents() or (None if plan is None else plan.contents)

    def _may_begin(self) -> bool:
        """Whether another recording may begin: the first one of a data set fixes what the others are read for."""
        room = self._waiting and len(self._under_way) < self._ahead
        return bool(room) and (not self._under_way or self._expected_contents() is not None)

    def _begin_next(self) -> None:
        path, work = self._waiting.popleft()
        staged = self._store.layout.staging / f"{self._begun:06d}"
        self._begun += 1
        self._under_way.append(self._candidate(path, self._expected_contents(), staged, work))

    def _candidate(self, path: Path, fixed: Contents | None, staged: Path, work: Work) -> Candidate:
        known = frozenset(sha256 for sha256, settings in self._known.items() if settings == self._job.settings_hash)
        return Candidate(path, self._job, self._workers, fixed=fixed, known=known, staged=staged, work=work)

    def _expected_numbering(self, position: int) -> Numbering:
        """The number of an episode if all before it in the line are added; where they are not, it is numbered again."""
        number = self._store.numbering(None)
        for candidate in list(self._under_way)[:position]:
            if candidate.plan is not None:
                number = Numbering(number.episode_index + 1, number.index_from + int(candidate.plan.ticks_ns.size))
        return number

    def _end(self, candidate: Candidate) -> None:
        """The recording that was first in the line is added or left out, or begins again as the first."""
        stays = candidate.fixed == self._contents()
        if stays:
            self._conclude(candidate)
        if not self._job.dry_run:
            discard(candidate.staged)
        self._progress.advance(0, candidate.unbegun)
        if stays:
            self._concluded += 1
            self._progress.done(self._concluded, source_name(candidate.path))
        else:
            # It was read for contents that the data set has not got after all: the first recording failed. What was
            # counted once is not counted again.
            again = self._candidate(candidate.path, self._contents(), candidate.staged, Work())
            self._under_way.appendleft(again)

    def _conclude(self, candidate: Candidate) -> None:
        """The recording becomes an episode, or is left out with its reason."""
        try:
            match candidate.phase:
                case Ready(planned=planned, joined=joined):
                    self._report.bytes_in += planned.size
                    if self._known.get(planned.sha256) == self._job.settings_hash:
                        self._keep(candidate.path, planned.sha256)
                    else:
                        self._report.episodes.append(self._added(candidate.path, planned, joined))
                case Kept(sha256=sha256):
                    self._keep(candidate.path, sha256)
                case Failed(error=error):
                    raise error
        except OutputError:
            raise
        except DatasetsError as error:
            logger.warning("%s", error)
            self._report.quarantined.append(Quarantined.of(candidate.path, error))

    def _added(self, path: Path, planned: Planned, joined: Joined | None) -> EpisodeSummary:
        job = self._job
        if isinstance(self._store, Foreseen):
            summary = foresee_episode(self._store, path, planned, job.robot, job.config)
        elif joined is None:
            raise ValueError("only a dry run adds what was not joined")
        else:
            summary = add_episode(self._store, path, planned, joined, job.robot, job.config)
        self._known[planned.sha256] = job.settings_hash
        return summary

    def _keep(self, path: Path, sha256: str) -> None:
        """Leave an episode as it is; only its place is a name, which may be another one now."""
        name, place = source_name(path), place_of(path, self._job.config)
        self._report.skipped.append(name)
        if place and self._store.set_place(sha256, place):
            self._report.placed[name] = place
