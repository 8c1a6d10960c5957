"""What labelling did, and what it stands on: printed, and kept in ``navtool/labels.json``."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Bool, Int64

from navtool.base.note import Note
from navtool.base.plain import plain_fields
from navtool.datasets.labels.rules import RuleResult
from navtool.pipeline.arrays import Array


@dataclass(slots=True)
class RuleReport:
    """One rule over all episodes."""

    episodes: int = 0
    """Episodes that the rule could be applied to."""
    intervals: int = 0
    """Portions that it found."""
    not_applicable: dict[str, list[int]] = field(default_factory=dict)
    """Episodes that it could say nothing about, by reason."""

    def add(self, episode: int, result: RuleResult) -> None:
        """Count one episode."""
        if result.not_applicable is None:
            self.episodes += 1
            self.intervals += len(result.intervals)
        else:
            self.not_applicable.setdefault(result.not_applicable, []).append(episode)


@dataclass(frozen=True, slots=True)
class EventsFile:
    """The events file that was applied."""

    name: str
    sha256: str
    events: int


@dataclass(slots=True, kw_only=True)
class LabelReport:
    """The labels of a data set.

    Attributes:
        dataset: The data set's folder.
        episodes: Number of episodes.
        rows: Number of rows.
        failed_rows: Rows with outcome 0.
        known_steps: Steps of E_t that are known, over all rows.
        all_steps: Rows times horizon.
        negatives: Rows with a known failed step: the negative samples (docs/papers.md, GrASPE V-B).
        reasons: Rows by reason; rows without one are not listed.
        rules: Each rule's result.
        events: The events file; None without one.
        rewritten: Episodes whose data file changed.
        notes: What a user should look at.
    """

    dataset: str
    episodes: int = 0
    rows: int = 0
    failed_rows: int = 0
    known_steps: int = 0
    all_steps: int = 0
    negatives: int = 0
    reasons: dict[str, int] = field(default_factory=dict)
    rules: dict[str, RuleReport] = field(default_factory=dict)
    events: EventsFile | None = None
    rewritten: list[int] = field(default_factory=list)
    notes: list[Note] = field(default_factory=list)

    def add_rules(self, episode: int, results: tuple[RuleResult, ...]) -> None:
        """Count what the rules say of one episode."""
        for result in results:
            self.rules.setdefault(result.rule, RuleReport()).add(episode, result)

    def add_rows(self, outcome: Int64[Array, " rows"], known: Bool[Array, "rows horizon"]) -> None:
        """Count one episode's rows."""
        ahead = (np.arange(len(outcome))[:, None] + np.arange(known.shape[1])).clip(max=len(outcome) - 1)
        self.failed_rows += int((outcome == 0).sum())
        self.known_steps += int(known.sum())
        self.all_steps += known.size
        self.negatives += int((known & (outcome[ahead] == 0)).any(axis=1).sum())

    def add_reasons(self, counts: Mapping[str, int]) -> None:
        """Count one episode's rows by reason."""
        for reason, rows in counts.items():
            if reason:
                self.reasons[reason] = self.reasons.get(reason, 0) + rows

    def to_json(self) -> dict[str, object]:
        """The report as ``navtool label --json`` prints it."""
        return plain_fields(self)
