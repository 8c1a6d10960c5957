"""Are the labels believable by themselves? With a wrong rule or flag, failures are too many, or follow the speed."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from jaxtyping import Bool

from navtool.base.files import read_json
from navtool.datasets.check.findings import Findings, Severity, name_of
from navtool.datasets.store.reader import Episode, NavDataset
from navtool.datasets.store.schema import STATE_KEY
from navtool.pipeline.arrays import Array

MOSTLY = 0.5
"""A recording of which a larger share failed is worth a look,"""
NEARLY_ALL = 0.9
"""and one of which a rule calls so much failed is not to be trained on."""
REASON_SHARE = 0.3
"""So is a reason that a larger share of all rows has."""
COINCIDE = 0.8
"""Failures follow the speed where of all rows that failed or moved so large a share did both."""
DRIVES_MPS, TURNS_RADPS = 0.1, 0.15
_LEAST_S = 3.0
"""Shorter movements and stands say nothing."""
_STAND = frozenset({"stuck", "collision", "slip"})
"""Reasons whose rows stand, or do not move as the speed says, by what they are."""


def check_plausible(dataset: NavDataset) -> Findings:
    """Not most of a recording failed, not exactly while it drove or stood, and no reason has a third of all rows."""
    outcomes, reasons = dataset.column("label.outcome"), dataset.column("label.reason")
    told: dict[str, Any] = read_json(dataset.layout.beside / "labels.json", "run `navtool label`")
    rules = frozenset(told.get("rules", ()))
    for episode in dataset.episodes:
        rows = slice(episode.start, episode.stop)
        yield from _shares(episode, outcomes[rows] == 0, reasons[rows], rules)
        yield from _with_speed(dataset, episode, outcomes[rows] == 0, reasons[rows], rules)
    for reason in _named(reasons):
        share = float((reasons == reason).mean())
        if share >= REASON_SHARE:
            yield Severity.WARN, "label.reason", f"{share:.0%} of all rows are '{reason}': {_look_at(reason, rules)}"


def _shares(episode: Episode, failed: Bool[Array, " rows"], reasons: Array, rules: frozenset[str]) -> Findings:
    share = float(failed.mean())
    if share < MOSTLY:
        return
    reason = max(_named(reasons[failed]), key=lambda name: int((reasons == name).sum()), default="")
    by_rule = share >= NEARLY_ALL and reason in rules
    severity = Severity.FAIL if by_rule else Severity.WARN
    yield severity, name_of(episode), f"{share:.0%} of it failed, mostly by '{reason}': {_look_at(reason, rules)}"


def _with_speed(
    dataset: NavDataset, episode: Episode, failed: Bool[Array, " rows"], reasons: Array, rules: frozenset[str]
) -> Findings:
    rows = slice(episode.start, episode.stop)
    state, valid = dataset.column(STATE_KEY)[rows], dataset.column("valid.state")[rows]
    moves = (np.abs(state) > (DRIVES_MPS, TURNS_RADPS)).any(axis=1)
    least = _LEAST_S * dataset.fps
    for reason in _named(reasons[failed]):
        of_reason = failed & (reasons == reason)
        for while_, severity, flags in (
            ("drives", Severity.FAIL if reason in rules else Severity.WARN, moves & valid),
            ("stands", Severity.WARN, ~moves & valid),
        ):
            if while_ == "stands" and reason in _STAND:
                continue
            if min(of_reason.sum(), flags.sum(), (valid & ~flags).sum()) < least:
                continue
            if (of_reason & flags).sum() >= COINCIDE * ((of_reason & valid) | flags).sum():
                what = f"'{reason}' is nearly all of the time in which it {while_}, and no other"
                yield severity, name_of(episode), f"{what}: {_look_at(reason, rules)}"


def _named(reasons: Array) -> Iterator[str]:
    return (reason for reason in np.unique(reasons.astype(str)).tolist() if reason)


def _look_at(reason: str, rules: frozenset[str]) -> str:
    """Where such a label comes from."""
    if reason == "intervention":
        return "look at the flag's meaning; it may be true where the robot is free"
    return f"look at the settings of the rule, {reason}.*" if reason in rules else "look at the events file"
