"""``navtool delete``, ``split``, ``merge``, ``compact`` and ``migrate``."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from version_2 import as_version_2

from navtool.cli.compose import UsageError
from navtool.cli.edit_report import episode_numbers
from navtool.datasets.store.reader import NavDataset

Call = Callable[..., Any]


def test_a_data_set_is_split_and_merged_and_loses_an_episode(
    navtool_here: Call, labelled_dataset: Path, tmp_path: Path
) -> None:
    parts = navtool_here("split", labelled_dataset, "train=0,2", "test=1", "--out", tmp_path, "--json")
    assert parts.code == 0, parts.err
    assert [made["rows"] for made in json.loads(parts.out)["datasets"]] == [120, 60]
    merged = navtool_here("merge", tmp_path / "test", tmp_path / "train", "--out", tmp_path / "merged")
    assert (merged.code, "180 rows in 3 episodes" in " ".join(merged.out.split())) == (0, True), merged.err
    left = navtool_here("delete", tmp_path / "merged", "1-2", "--out", tmp_path / "left")
    assert left.code == 0, left.err
    (episode,) = NavDataset(tmp_path / "left").episodes
    assert episode.place == "place-1"
    assert navtool_here("check", tmp_path / "left").code == 0
    assert navtool_here("label", tmp_path / "left").code == 0


def test_a_compact_copy_is_checked_with_the_cure(navtool_here: Call, labelled_dataset: Path, tmp_path: Path) -> None:
    assert navtool_here("compact", labelled_dataset, "--out", tmp_path / "compact").code == 0
    checked = navtool_here("check", tmp_path / "compact")
    assert checked.code == 1
    assert "nothing beside them" in checked.err
    assert "navtool delete" in checked.err


def test_an_older_data_set_is_told_to_migrate_and_does(
    navtool_here: Call, labelled_dataset: Path, tmp_path: Path
) -> None:
    as_version_2(labelled_dataset, tmp_path / "old")
    refused = navtool_here("check", tmp_path / "old")
    assert (refused.code, "navtool migrate" in refused.err) == (1, True)
    assert navtool_here("migrate", tmp_path / "old", "--out", tmp_path / "new").code == 0
    assert navtool_here("check", tmp_path / "new").code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "said"),
    [
        (("delete", "{data}", "x", "--out", "{out}"), 2, "list them as 0,3-5"),
        (("delete", "{data}", "2-1", "--out", "{out}"), 2, "list them as 0,3-5"),
        (("delete", "{data}", "7", "--out", "{out}"), 1, "it has 0 to 2"),
        (("delete", "{data}", "0", "--out", "{data}"), 2, "is there already"),
        (("delete", "{data}", "0-999999999", "--out", "{out}"), 1, "there is no episode 999999999"),
        (("delete", "{data}", "9" * 5000, "--out", "{out}"), 2, "list them as 0,3-5"),
        (("delete", "{data}", "\u0663", "--out", "{out}"), 2, "list them as 0,3-5"),
        (("delete", "{out}", "0", "--out", "{out}"), 2, "there is no such file"),
        (("split", "{data}", "a", "--out", "{out}"), 2, "name parts as"),
        (("split", "{data}", "../a=0", "--out", "{out}"), 2, "name parts as"),
        (("split", "{data}", "..=0", "--out", "{out}/in"), 2, "name parts as"),
        (("split", "{data}", "=0", "--out", "{out}"), 2, "name parts as"),
        (("split", "{data}", "a=0", "b=0,1", "--out", "{out}"), 1, "episodes 0 are named twice"),
        (("merge", "{data}", "{data}", "--out", "{out}"), 1, "delete it from one of them first"),
        (("migrate", "{data}", "--out", "{out}"), 1, "version 2 becomes 3"),
    ],
)
def test_wrong_calls_say_the_cure(
    navtool_here: Call, labelled_dataset: Path, tmp_path: Path, arguments: tuple[str, ...], code: int, said: str
) -> None:
    out = tmp_path / "out"
    done = navtool_here(*(argument.format(data=labelled_dataset, out=out) for argument in arguments))
    assert (done.code, said in " ".join(done.err.split())) == (code, True), done.err
    assert not out.exists()


def test_episodes_are_listed_as_numbers_and_ranges() -> None:
    assert episode_numbers("0,3-5, 9", 10) == [0, 3, 4, 5, 9]
    with pytest.raises(UsageError):
        episode_numbers("", 10)
