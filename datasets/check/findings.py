"""What a check finds, and the report of them all."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import numpy as np
from jaxtyping import Bool

from navtool.base.plain import plain_fields
from navtool.datasets.store.reader import Episode, NavDataset
from navtool.pipeline.arrays import Array


class Severity(StrEnum):
    """How bad a finding is: a data set with a FAIL must not be trained on."""

    FAIL = "FAIL"
    WARN = "WARN"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong."""

    severity: Severity
    check: str
    where: str
    message: str


@dataclass(slots=True)
class CheckReport:
    """All findings, and what was looked at."""

    dataset: str
    episodes: int = 0
    rows: int = 0
    checks: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)
    splits: dict[str, str] = field(default_factory=dict)
    """What each split holds that a file names; empty where none was given."""

    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
        return all(finding.severity is not Severity.FAIL for finding in self.findings)

    def to_json(self) -> dict[str, object]:
        """The report as ``navtool check --json`` prints it."""
        return {"passed": self.passed, **plain_fields(self)}


type Findings = Iterator[tuple[Severity, str, str]]
"""Severity, place and message."""


def name_of(episode: Episode) -> str:
    """An episode as findings call it."""
    return f"episode {episode.index} ({episode.source})"


def short(dataset: NavDataset, path: Path) -> str:
    """A file by its path within the data set."""
    return path.relative_to(dataset.root).as_posix()


def first_line(error: BaseException) -> str:
    """What an error says first."""
    return str(error).splitlines()[0] if str(error) else type(error).__name__


def runs(flags: Bool[Array, " n"]) -> list[tuple[int, int]]:
    """Beginning and end (exclusive) of every run of true flags."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return [(int(first), int(end)) for first, end in zip(edges[::2], edges[1::2], strict=True)]
