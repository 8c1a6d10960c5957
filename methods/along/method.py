"""What a method is that walks along a recording or an episode."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.methods.along.observation import Beside, Observation, Skip, Ticks
from navtool.methods.along.place_truth import PlaceTruth
from navtool.methods.along.report import Report
from navtool.methods.along.streams import Streams
from navtool.methods.along.writers import Writer


@dataclass(slots=True)
class Walked:
    """What a walk has come to so far, over all inputs of a command."""

    out: str
    """The folder of the output."""
    names: list[str] = field(default_factory=list)
    """Names of the inputs."""
    ticks: int = 0
    results: int = 0
    duration_s: float = 0.0
    unread: Counter[str] = field(default_factory=Counter)
    """Ticks that could not be read, by reason."""
    skipped: Counter[str] = field(default_factory=Counter)
    """Ticks that the method skipped, by reason."""
    notes: list[Note] = field(default_factory=list)
    """What a user should look at in the inputs."""
    skip_notes: list[Note] = field(default_factory=list)
    """What a user should look at in ticks that the method skipped: of each reason, the first one's."""
    written: dict[str, int] = field(default_factory=dict)
    """Results in each output."""


class Method[T, R, P: Report](ABC):
    """A method along a recording: a step from an observation to a result, and what is written of it.

    The loop gives it the folder that is there whole or not at all, "done before", lineage, progress, the thread beside
    for writing, and counts what is skipped. One object walks once.

    Type parameters: T is what ticks, R a result, P the report.
    """

    kind: ClassVar[str]
    """What a lineage calls the output, such as ``navtool intensity maps``."""
    preview: ClassVar[int] = 1
    """How many readings ``begin`` looks at, before anything is written of an input."""
    several: ClassVar[bool] = False
    """Whether it may walk along several inputs, for one output."""
    needs_truth: ClassVar[bool] = False
    """Whether it is of use only where it is known what stands there."""
    odometry_gap_s: float = 0.25
    """Poses of the odometry further apart than this are not interpolated between."""
    beside: tuple[Beside[object], ...] = ()
    """What it asks for at a tick, beside what ticks."""
    ticks: Ticks[T]
    """What it walks along."""
    report_type: type[P]
    """The dataclass of its report."""

    @property
    @abstractmethod
    def settings(self) -> Mapping[str, object]:
        """Everything that decides the results, beside the input: hashed for the lineage."""

    def begin(  # noqa: B027 - not every method looks first
        self, streams: Streams, known: PlaceTruth | None, first: Sequence[T]
    ) -> None:
        """Look at an input before its first step.

        Args:
            streams: The input's.
            known: What stands there, in the frame of its odometry; None where nobody knows.
            first: The first readings, one at least and ``preview`` at most; steps begin with them again.

        Raises:
            DatasetsError: Nothing can be made of it, with the reason and the cure.
        """

    @abstractmethod
    def step(self, observation: Observation[T]) -> R | Skip | None:
        """The result of a tick; None where it only adds to what the whole walk gives."""

    def end(self, streams: Streams, walked: Walked) -> None:
        """Look at what an input came to, behind its last step.

        Raises:
            DatasetsError: It gave nothing, with the reason and the cure.
        """
        if not walked.results:
            raise self.nothing(streams, walked)

    def nothing(self, streams: Streams, walked: Walked) -> DatasetsError:
        """What is wrong where no tick gives a result."""
        reasons = ", ".join(f"{count} {reason}" for reason, count in (walked.unread + walked.skipped).items())
        what = f"none of the {walked.ticks} {self.ticks.noun} gives a result{': ' if reasons else ''}{reasons}"
        return DatasetsError(what, where=streams.name, cure="look at it with `navtool inspect --report`")

    def writers(self, folder: Path, streams: Streams) -> Sequence[Writer[R]]:  # noqa: ARG002 - for those that have some
        """What writes the results of an input into a folder; none where the whole walk gives the output."""
        return ()

    @abstractmethod
    def report(self, walked: Walked) -> P:
        """What is reported of the whole walk.

        Raises:
            DatasetsError: The whole walk gives nothing.
        """

    def finish(self, folder: Path, report: P) -> None:  # noqa: B027 - the writers may have written all
        """Write what the whole walk gives, such as a page."""
