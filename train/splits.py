"""Which episodes train, validate and test a model: whole places, never shared between splits."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.train.errors import TrainError
from navtool.train.source import EpisodeView


class Split(StrEnum):
    """A part of the data set; ``all`` is every episode."""

    train = "train"
    val = "val"
    test = "test"
    all = "all"


class GroupBy(StrEnum):
    """What must not be shared between splits."""

    place = "place"
    """Places, and runs where the place of a run is unknown."""
    run = "run"
    """Runs only: the splits may share places, and figures then say little about new places."""


@dataclass(kw_only=True, slots=True)
class SplitConfig:
    """How episodes are divided.

    Groups named in a list go where the list says. The others are drawn by ``seed`` and fill the splits without a list
    by their fractions of the rows; they stay out where all three splits have a list.
    """

    val_fraction: float = 0.15
    """Share of the rows for validation, in (0, 1); it is approximate, as groups stay whole."""

    test_fraction: float = 0.15
    """Share of the rows for testing, in [0, 1); 0 keeps none."""

    group_by: GroupBy = GroupBy.place
    """What must not be shared between splits."""

    train_places: list[str] = field(default_factory=list)
    """Places (or runs, as ``group_by`` says) that train; empty = by fraction."""

    val_places: list[str] = field(default_factory=list)
    """Places that validate; empty = by fraction."""

    test_places: list[str] = field(default_factory=list)
    """Places that test; empty = by fraction."""

    seed: int = 0
    """Draws the groups. Apart from the training seed: runs of a sweep over seeds share their test data."""

    def __post_init__(self) -> None:
        named = [*self.train_places, *self.val_places, *self.test_places]
        twice = sorted({name for name in named if named.count(name) > 1})
        total = self.val_fraction + self.test_fraction
        refuse(
            outside(self, 0, 1, "val_fraction", above=True, below=True, cure="such as 0.15"),
            outside(self, 0, 1, "test_fraction", below=True, cure="such as 0.15"),
        )
        refuse(
            fault("val_fraction", f"with test_fraction {total}, which leaves nothing to train on", when=total >= 1),
            fault("", f"{', '.join(twice)} named in two splits; places are never shared", when=bool(twice)),
        )


@dataclass(frozen=True, slots=True)
class Splits:
    """Episode numbers of each split, ascending."""

    train: tuple[int, ...]
    val: tuple[int, ...]
    test: tuple[int, ...]

    def episodes(self, split: Split) -> tuple[int, ...]:
        """The episodes of a split; those of all three for ``all``."""
        parts = {Split.train: self.train, Split.val: self.val, Split.test: self.test}
        return parts[split] if split is not Split.all else tuple(sorted(self.train + self.val + self.test))


def split_episodes(episodes: Sequence[EpisodeView], config: SplitConfig) -> Splits:
    """Divide episodes into train, val and test.

    A function of the episodes and the configuration alone. No two splits share a group, and each split that is wanted
    has at least one.

    Raises:
        TrainError: There are too few groups, or a list names one that does not exist.
    """
    groups = _groups(episodes, config.group_by)
    chosen = _named(groups, config)
    targets = {Split.train: 1.0 - config.val_fraction - config.test_fraction, Split.val: config.val_fraction}
    if config.test_fraction > 0.0:
        targets[Split.test] = config.test_fraction
    open_splits = [split for split in targets if split not in chosen.values()]
    rest = sorted(name for name in groups if name not in chosen)
    if len(rest) < len(open_splits):
        raise _too_few(groups, rest, open_splits, config.group_by)
    rows = {name: sum(episode.stop - episode.start for episode in group) for name, group in groups.items()}
    chosen |= _fill(rest, rows, {split: targets[split] for split in open_splits}, config.seed)
    members = {
        split: tuple(
            sorted(episode.index for name, group in groups.items() for episode in group if chosen.get(name) is split)
        )
        for split in (Split.train, Split.val, Split.test)
    }
    return Splits(train=members[Split.train], val=members[Split.val], test=members[Split.test])


def _groups(episodes: Sequence[EpisodeView], group_by: GroupBy) -> dict[str, list[EpisodeView]]:
    """Episodes by the name of what they share; a run recorded over several places joins these into one group."""
    groups: dict[str, list[EpisodeView]] = {}
    for episode in episodes:
        own = episode.place if group_by is GroupBy.place and episode.place else episode.source
        joined = [
            name for name, group in groups.items() if name == own or any(e.source == episode.source for e in group)
        ]
        members = [member for name in joined for member in groups.pop(name)]
        groups[joined[0] if joined else own] = [*members, episode]
    return groups


def _named(groups: dict[str, list[EpisodeView]], config: SplitConfig) -> dict[str, Split]:
    lists = {Split.train: config.train_places, Split.val: config.val_places, Split.test: config.test_places}
    chosen = {name: split for split, names in lists.items() for name in names}
    unknown = sorted(set(chosen) - set(groups))
    if unknown:
        raise TrainError(
            f"split names {', '.join(unknown)}, which the data set does not have",
            where="split",
            cure=f"use one of {', '.join(sorted(groups))}",
        )
    return chosen


def _fill(names: list[str], rows: dict[str, int], targets: dict[Split, float], seed: int) -> dict[str, Split]:
    """Give each group, in drawn order, to the split that lacks most rows; none of the splits stays empty."""
    if not targets:
        return {}
    total, weight = sum(rows[name] for name in names), sum(targets.values())
    lacking = {split: total * share / weight for split, share in targets.items()}
    empty = list(targets)
    filled: dict[str, Split] = {}
    order = np.random.default_rng(seed).permutation(len(names))
    for left, name in zip(range(len(names), 0, -1), (names[i] for i in order), strict=True):
        split = max(empty if left <= len(empty) else targets, key=lambda candidate: lacking[candidate])
        filled[name] = split
        lacking[split] -= rows[name]
        if split in empty:
            empty.remove(split)
    return filled


def _too_few(
    groups: Mapping[str, Sequence[EpisodeView]], rest: Sequence[str], wanted: Sequence[Split], group_by: GroupBy
) -> TrainError:
    """What is wrong, and those of the cures that help with these recordings."""
    noun = "place" if group_by is GroupBy.place else "recording"
    cures = [f"record more {noun}s"]
    if len(rest) == len(wanted) - 1 and Split.test in wanted:
        cures.append("or set split.test_fraction=0, and judge the run with `navtool evaluate RUN --split val`")
    recordings = {episode.source for group in groups.values() for episode in group}
    if group_by is GroupBy.place and len(recordings) >= len(Split) - 1:
        cures.append("or let splits share places with split.group_by=run; the figures then say little of new places")
    names = ", ".join(sorted(groups)) or "none"
    what = f"{len(rest)} {noun}{'' if len(rest) == 1 else 's'} for {len(wanted)} splits"
    has = f"({', '.join(split.value for split in wanted)}); the data set has {names}"
    return TrainError(f"{what} {has}", where="split", cure="; ".join(cures))
