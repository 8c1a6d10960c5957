"""Do splits keep episodes apart? Those that the data set names itself, and those of a training run."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

from navtool.base.errors import DatasetsError
from navtool.base.files import read_json
from navtool.datasets.check.findings import Findings, Severity
from navtool.datasets.store.reader import NavDataset

_SHOWN = 5
_MOST = 1_000_000
_CURE = 'name a run\'s lineage.json, or a file like {"train": [0, 1], "val": "2:4"}'


class Member(NamedTuple):
    """An episode of a split."""

    episode: int
    source: str | None = None
    """The recording that it was made from, where the split says so."""
    sha256: str | None = None
    """The recording's hash, where it is said."""


type Splits = Mapping[str, Sequence[Member]]
"""By the name of the split."""


def check_own_splits(dataset: NavDataset) -> Findings:
    """The splits of ``meta/info.json``."""
    where = "meta/info.json"
    try:
        splits = _parsed(read_json(dataset.layout.info, "").get("splits"))
    except ValueError as error:
        yield Severity.FAIL, where, f"splits: {error}"
        return
    yield from check_splits(dataset, splits, where)


def read_splits(path: Path) -> Splits:
    """The splits in a file: a run's ``lineage.json``, or episodes by split as numbers or as ranges like ``0:80``.

    Raises:
        DatasetsError: The file holds no splits.
    """
    content = read_json(path, _CURE)
    try:
        return _with_hashes(_parsed(content.get("split", content)), content.get("dataset"))
    except ValueError as error:
        raise DatasetsError(f"holds no splits: {error}", where=path, cure=_CURE) from error


def check_splits(dataset: NavDataset, splits: Splits, where: str) -> Findings:
    """Every episode is there, none and no recording is in two splits; places and moments that two share are named.

    Args:
        where: What names the splits.
    """
    made = dict(enumerate(dataset.provenance()))
    for name, members in splits.items():
        if beyond := [member.episode for member in members if member.episode not in made]:
            yield Severity.FAIL, where, f"{name} has the episodes {_some(beyond)}; there are {len(made)}"
        for number, source, sha256 in members:
            found = made.get(number, {})
            if source is not None and found.get("source", source) != source:
                yield Severity.FAIL, where, f"{name} knows episode {number} as {source}; it is {found['source']}"
            elif sha256 is not None and found.get("sha256", sha256) != sha256:
                what = f"{name} knows episode {number}, {source}, by another hash: it is another data set's"
                yield Severity.FAIL, where, what
    numbers = {name: {member.episode for member in members} for name, members in splits.items()}
    for one, other in combinations(splits, 2):
        both = f"{one} and {other}"
        if shared := sorted(numbers[one] & numbers[other]):
            yield Severity.FAIL, where, f"{both} share the episodes {_some(shared)}"
        apart = [
            (made[x], made[y])
            for x in sorted(numbers[one] & set(made))
            for y in sorted(numbers[other] & set(made))
            if x != y
        ]
        if same := sorted({y["source"] for x, y in apart if x["sha256"] == y["sha256"]}):
            yield Severity.FAIL, where, f"{both} share the recordings {_some(same)}"
        if places := sorted({y["place"] for x, y in apart if x["place"] == y["place"] != ""}):
            yield Severity.WARN, where, f"{both} share the places {_some(places)}"
        if at_once := [f"{x['source']} with {y['source']}" for x, y in apart if _at_once(x, y)]:
            yield Severity.WARN, where, f"{both} share moments: {_some(at_once)}"


def told_splits(dataset: NavDataset, splits: Splits) -> dict[str, str]:
    """How much each split holds, and of which places; of episodes that there are."""
    told = {}
    for name, members in splits.items():
        there = [dataset.episodes[number] for number, *_ in members if 0 <= number < len(dataset.episodes)]
        places = sorted({episode.place or episode.source for episode in there})
        rows = sum(len(episode) for episode in there)
        told[name] = f"{len(there)} episodes, {rows} rows: {_some(places) or 'none'}"
    return told


def _at_once(one: Mapping[str, Any], other: Mapping[str, Any]) -> bool:
    return bool(one["start_ns"] < other["end_ns"] and other["start_ns"] < one["end_ns"])


def _some(values: Sequence[object]) -> str:
    more = f" and {len(values) - _SHOWN} more" if len(values) > _SHOWN else ""
    return ", ".join(str(value) for value in values[:_SHOWN]) + more


def _parsed(content: object) -> Splits:
    if not isinstance(content, dict):
        raise ValueError(f"{type(content).__name__} instead of an object")
    return {str(name): _members(str(name), entry) for name, entry in content.items()}


def _with_hashes(splits: Splits, made: object) -> Splits:
    """The splits of a run, with the hashes of the recordings of the data set that it was trained on."""
    recordings = made.get("recordings") if isinstance(made, dict) else None
    if not isinstance(recordings, list):
        return splits
    hashes = {
        number: entry["sha256"]
        for number, entry in enumerate(recordings)
        if isinstance(entry, dict) and isinstance(entry.get("sha256"), str)
    }
    return {
        name: [member._replace(sha256=hashes.get(member.episode)) for member in members]
        for name, members in splits.items()
    }


def _members(name: str, entry: object) -> list[Member]:
    if isinstance(entry, str):
        first, colon, end = entry.partition(":")
        if colon and first.isdecimal() and end.isdecimal() and int(end) <= _MOST:
            return [Member(number) for number in range(int(first), int(end))]
    elif isinstance(entry, list):
        pairs = [(x.get("episode"), x.get("source")) if isinstance(x, dict) else (x, None) for x in entry]
        members = [Member(number, source) for number, source in pairs if _is_number(number) and _is_source(source)]
        if len(members) == len(pairs):
            return members
    raise ValueError(f"{name} is neither a range nor a list of episodes")


def _is_number(value: object) -> TypeGuard[int]:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_source(value: object) -> TypeGuard[str | None]:
    return value is None or isinstance(value, str)
