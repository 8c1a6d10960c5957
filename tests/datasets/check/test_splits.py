"""Splits that share episodes, recordings, places or moments are found, whoever names them."""

import json
import shutil
from pathlib import Path

import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset


def edit_json(path: Path, **values: object) -> None:
    path.write_text(json.dumps(json.loads(path.read_text()) | values))


def test_the_splits_of_a_run_are_looked_at_with_the_data_set(labelled_dataset: Path, tmp_path: Path) -> None:
    dataset = Path(shutil.copytree(labelled_dataset, tmp_path / "dataset"))
    lineage = tmp_path / "lineage.json"
    sources = [episode.source for episode in NavDataset(dataset).episodes]

    def told(**splits: list[object]) -> set[tuple[str, str]]:
        lineage.write_text(json.dumps({"split": splits}))
        found = check_dataset(dataset, splits=lineage).findings
        return {(f.severity.value, f.message) for f in found if f.check == "named splits"}

    def members(*numbers: int) -> list[object]:
        return [{"episode": number, "source": sources[number], "place": ""} for number in numbers]

    times = ("WARN", f"train and val share moments: {sources[0]} with {sources[2]}, {sources[1]} with {sources[2]}")
    assert told(train=members(0, 1), val=members(2)) == {times}
    assert ("FAIL", "train and val share the episodes 1") in told(train=members(0, 1), val=members(1, 2))
    assert ("FAIL", "val has the episodes 7; there are 3") in told(train=members(0), val=[7])
    other = {"episode": 2, "source": sources[1]}
    assert ("FAIL", f"val knows episode 2 as {sources[1]}; it is {sources[2]}") in told(train=members(0), val=[other])
    made = [Layout(dataset).episode(episode) / "provenance.json" for episode in range(3)]
    edit_json(made[2], place=json.loads(made[0].read_text())["place"])
    assert ("WARN", "train and val share the places place-0") in told(train=members(0, 1), val=members(2))
    edit_json(made[2], sha256=json.loads(made[0].read_text())["sha256"])
    assert ("FAIL", f"train and val share the recordings {sources[2]}") in told(train=members(0, 1), val=members(2))
    lineage.write_text(
        json.dumps(
            {
                "split": {"train": members(0), "val": members(1)},
                "dataset": {"recordings": [{"sha256": one["sha256"]} for one in NavDataset(dataset).provenance()]},
            }
        )
    )
    assert check_dataset(dataset, splits=lineage).splits.keys() == {"train", "val"}
    assert "1 episodes" in check_dataset(dataset, splits=lineage).splits["train"]
    edit_json(made[1], sha256="0" * 64)
    found = [f.message for f in check_dataset(dataset, splits=lineage).findings if f.check == "named splits"]
    assert f"val knows episode 1, {sources[1]}, by another hash: it is another data set's" in found
    for text in ("[]", "{}{", '{"train": 3}', '{"train": [0.5]}', '{"train": "0:99999999999"}'):
        lineage.write_text(text)
        with pytest.raises(DatasetsError, match=r"no splits|JSON"):
            check_dataset(dataset, splits=lineage)
