"""How far a recording is on its way into a data set."""

from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.join_step import Joined
from navtool.datasets.ingest.plan_step import Known, Planned
from navtool.datasets.ingest.segment import Segment, SegmentResult


@dataclass(frozen=True, slots=True)
class Planning:
    """It is hashed and read once."""

    planned: Future[Planned | Known]


@dataclass(frozen=True, slots=True)
class Reading:
    """Its segments are read."""

    planned: Planned
    segments: Sequence[Segment]
    results: Sequence[Future[SegmentResult]]


@dataclass(frozen=True, slots=True)
class Joining:
    """What was read is joined."""

    planned: Planned
    joined: Future[Joined]


@dataclass(frozen=True, slots=True)
class Ready:
    """Nothing more is to be done before its turn comes."""

    planned: Planned
    joined: Joined | None
    """None in a dry run."""


@dataclass(frozen=True, slots=True)
class Kept:
    """The data set has it already."""

    sha256: str


@dataclass(frozen=True, slots=True)
class Failing:
    """It gives no episode; what was begun of it comes to its end."""

    error: DatasetsError
    begun: Sequence[Future[SegmentResult]]


@dataclass(frozen=True, slots=True)
class Failed:
    """It gives no episode."""

    error: DatasetsError


type Phase = Planning | Reading | Joining | Ready | Kept | Failing | Failed
"""Planning, reading, joining, ready; from planning also kept, and from any of the first three failing and failed."""


def awaited(phase: Phase) -> list[Future[Any]]:
    """What is still to be waited for."""
    futures: Sequence[Future[Any]]
    match phase:
        case Planning(planned=planned):
            futures = [planned]
        case Reading(results=results):
            futures = results
        case Joining(joined=joined):
            futures = [joined]
        case Failing(begun=begun):
            futures = begun
        case Ready() | Kept() | Failed():
            futures = []
    return [future for future in futures if not future.done()]
