"""What a run was made from: its data set, configuration, code, and which episodes it trained on."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from navtool.base.lineage import code_version, config_hash
from navtool.base.plain import plain
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.samples import SampleReport
from navtool.train.source import Source
from navtool.train.splits import Split, Splits

_PARTS = (Split.train, Split.val, Split.test)


def run_lineage(
    config: TrainConfig, source: Source, splits: Splits, reports: Mapping[Split, SampleReport]
) -> dict[str, Any]:
    """The content of ``lineage.json``: plain values; apart from the path the same for the same inputs and code."""
    episodes = {
        split.value: [
            {"episode": index, "source": source.episodes[index].source, "place": source.episodes[index].place}
            for index in splits.episodes(split)
        ]
        for split in _PARTS
    }
    return {
        "dataset_path": None if source.root is None else source.root.resolve().as_posix(),
        "dataset": plain(source.lineage()),
        "config_hash": config_hash(config),
        "code_version": code_version(),
        "split": episodes,
        "samples": {split.value: plain(report) for split, report in reports.items()},
    }


def splits_of(lineage: Mapping[str, Any], source: Source) -> Splits:
    """The episodes that the run's splits hold, in this data set.

    A data set that has grown since still has them under the same numbers.

    Raises:
        TrainError: This is another data set, or the lineage is damaged.
    """
    try:
        parts = {
            split: [(int(entry["episode"]), str(entry["source"])) for entry in lineage["split"][split.value]]
            for split in _PARTS
        }
    except (KeyError, TypeError, ValueError) as error:
        raise TrainError(f"holds no split ({error})", where="lineage.json", cure="train again") from error
    for index, name in (entry for entries in parts.values() for entry in entries):
        found = source.episodes[index].source if 0 <= index < len(source.episodes) else None
        if found != name:
            raise TrainError(
                f"the run knows episode {index} as {name}, this data set has {found or 'no such episode'} there",
                where="split",
                cure="give the data set that the run was trained on, or split=all to evaluate on every episode",
            )
    train, val, test = (tuple(index for index, _ in parts[split]) for split in _PARTS)
    return Splits(train=train, val=val, test=test)


def dataset_path(lineage: Mapping[str, Any], where: Path) -> Path:
    """The folder of the data set that a run was trained on.

    Raises:
        TrainError: The lineage does not say, as with a data set that was never in a folder.
    """
    path = lineage.get("dataset_path")
    if not isinstance(path, str):
        raise TrainError("does not say where the run's data set is", where=where, cure="name the data set's folder")
    return Path(path)


def check_same_data(old: Mapping[str, Any], new: Mapping[str, Any]) -> None:
    """Make sure that a resumed run sees what it saw before.

    Raises:
        TrainError: The data set, its labels or the split have changed.
    """
    changed = [name for name in ("dataset", "split", "samples") if old.get(name) != new.get(name)]
    if changed:
        raise TrainError(
            f"{' and '.join(changed)} changed since the run began",
            where="lineage.json",
            cure="begin a new run in another folder",
        )
