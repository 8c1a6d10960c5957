"""A recording that is to become an episode, on its way into the data set."""

from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Any

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.workers import Workers, outcome
from navtool.datasets.ingest.contents import refuse_missing_topics, refuse_other_contents
from navtool.datasets.ingest.job import Job
from navtool.datasets.ingest.join_step import join_step
from navtool.datasets.ingest.phase import Failed, Failing, Joining, Kept, Phase, Planning, Reading, Ready, awaited
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.plan_step import Known, Planned, plan_step
from navtool.datasets.ingest.segment import SegmentResult, cut_segments
from navtool.datasets.ingest.segment_step import segment_step
from navtool.datasets.ingest.work import Work
from navtool.datasets.store.schema import Contents
from navtool.datasets.store.staged_episode import Numbering


class Candidate:
    """One recording, and the phase that it is in.

    Making it begins its planning. Errors of the recording end in the phase `Failed`; those of the output are raised.

    Args:
        fixed: Contents of the data set that it is planned for; None where it would fix them.
        known: Content hashes of the recordings that need no work.
        staged: The folder for its episode's files.
        work: What its steps are expected to take.
    """

    def __init__(
        self,
        path: Path,
        job: Job,
        workers: Workers,
        *,
        fixed: Contents | None,
        known: frozenset[str],
        staged: Path,
        work: Work,
    ) -> None:
        self.path, self.fixed, self.staged = path, fixed, staged
        self.unbegun = work.reading + work.joining
        """Units of its work that no step counts."""
        self._job, self._workers, self._work = job, workers, work
        to = None if job.dry_run else staged
        planning = workers.submit(work.planning, plan_step, path, job.robot, job.config, fixed, known, to)
        self.phase: Phase = Planning(planning)

    @property
    def awaited(self) -> list[Future[Any]]:
        """What its phase waits for."""
        return awaited(self.phase)

    @property
    def ended(self) -> bool:
        """Whether nothing more is to be done before it is concluded."""
        return isinstance(self.phase, Ready | Kept | Failed)

    @property
    def plan(self) -> EpisodePlan | None:
        """The plan of the episode that it seems to become; None before it is planned, and where it becomes none."""
        match self.phase:
            case Reading(planned=planned) | Joining(planned=planned) | Ready(planned=planned):
                return planned.plan
            case _:
                return None

    def proceed(self, numbering: Numbering) -> None:
        """Go from phase to phase as far as what was begun has ended.

        Args:
            numbering: The number that its episode is likely to have.
        """
        while (following := self._following(numbering)) is not self.phase:
            self.phase = following

    def _following(self, numbering: Numbering) -> Phase:
        """The phase behind the present one, or that one as long as it lasts."""
        try:
            match self.phase:
                case Planning(planned=future) if future.done():
                    return self._after_planning(outcome(future))
                case Reading() as reading:
                    return self._after_reading(reading, numbering)
                case Joining(planned=planned, joined=joined) if joined.done():
                    return Ready(planned, outcome(joined))
                case Failing(error=error) as failing if not awaited(failing):
                    return Failed(error)
                case phase:
                    return phase
        except OutputError:
            raise
        except DatasetsError as error:
            return Failing(error, self._called_off())

    def _after_planning(self, planned: Planned | Known) -> Phase:
        if isinstance(planned, Known):
            return Kept(planned.sha256)
        plan = planned.plan
        if self._job.strict:
            _refuse_left_out(plan)
        refuse_other_contents(plan.contents, plan.found, allow_missing=self._job.allow_missing)
        refuse_missing_topics(self._job.robot, plan.topics, () if self._job.allow_missing else self._job.named)
        if self._job.dry_run:
            return Ready(planned, None)
        segments = cut_segments(plan)
        ticks = int(plan.ticks_ns.size)
        results = []
        for segment in segments:
            work = self._work.reading_of(segment, ticks)
            self.unbegun -= work
            results.append(self._workers.submit(work, segment_step, self.path, segment, self._job.config, self.staged))
        return Reading(planned, segments, results)

    def _after_reading(self, reading: Reading, numbering: Numbering) -> Phase:
        results = [outcome(future) for future in reading.results if future.done()]
        if len(results) < len(reading.results):
            return reading
        self.unbegun -= self._work.joining
        arguments = reading.planned.plan, reading.segments, results, numbering, self._job.config, self.staged
        return Joining(reading.planned, self._workers.submit(self._work.joining, join_step, *arguments))

    def _called_off(self) -> Sequence[Future[SegmentResult]]:
        """What was begun of its reading and goes on; the rest is not begun any more."""
        if not isinstance(self.phase, Reading):
            return []
        begun = []
        ticks = int(self.phase.planned.plan.ticks_ns.size)
        for segment, future in zip(self.phase.segments, self.phase.results, strict=True):
            if future.cancel():
                self.unbegun += self._work.reading_of(segment, ticks)
            else:
                begun.append(future)
        return begun


def _refuse_left_out(plan: EpisodePlan) -> None:
    """Where nothing may be left out, a recording is read whole or not at all.

    Raises:
        DatasetsError: A stream cannot be decoded, or its files are not sound.
    """
    left = [f"{stream} cannot be decoded" for stream in plan.left_out] + list(plan.faults)
    if left:
        raise DatasetsError("; ".join(left), cure="leave --strict out to take what can be read")
