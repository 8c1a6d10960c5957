"""Episodes deleted, split and merged: what ingest and labelling would have made of the recordings alone."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hashes import hashes
from ingesting import ingested

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.edit.assemble import in_parts, together, without_episodes
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.store.reader import NavDataset

Write = Callable[..., Path]
Drive = Callable[..., Any]


@pytest.fixture
def recordings(write_recording: Write, drive_entries: Drive) -> list[Path]:
    return [write_recording("mcap", drive_entries(2.0 + number, seed=number), f"run-{number}") for number in range(3)]


def test_what_is_left_is_what_ingest_makes_without_the_recording(recordings: list[Path], tmp_path: Path) -> None:
    ingested(recordings, tmp_path / "all")
    ingested([recordings[0], recordings[2]], tmp_path / "two")
    report = without_episodes(NavDataset(tmp_path / "all"), [1], tmp_path / "left", None)
    assert (report.episodes, report.rows) == (2, len(NavDataset(tmp_path / "two")))
    assert hashes(tmp_path / "left") == hashes(tmp_path / "two")


def test_parts_merged_again_are_the_data_set(labelled_dataset: Path, tmp_path: Path) -> None:
    whole = NavDataset(labelled_dataset)
    parts = in_parts(whole, {"a": [0], "b": [2, 1]}, tmp_path, None)
    assert [(part.episodes, part.rows) for part in parts] == [(1, 60), (2, 120)]
    together([NavDataset(tmp_path / "a"), NavDataset(tmp_path / "b")], tmp_path / "again", None)
    made, again = hashes(labelled_dataset), hashes(tmp_path / "again")
    assert {key for key in made if made[key] != again.get(key)} == {"navtool/labels.json"}
    assert set(again) == set(made)
    assert check_dataset(tmp_path / "again").passed
    assert check_dataset(tmp_path / "b").passed


def test_no_part_is_made_where_one_cannot_be(labelled_dataset: Path, tmp_path: Path) -> None:
    (tmp_path / "b").mkdir()
    (tmp_path / "b" / "notes.txt").touch()
    with pytest.raises(DatasetsError, match="is there already"):
        in_parts(NavDataset(labelled_dataset), {"a": [0], "b": [1]}, tmp_path, None)
    assert not (tmp_path / "a").exists()


def test_labels_are_kept_with_their_settings_and_counted_anew(labelled_dataset: Path, tmp_path: Path) -> None:
    whole = NavDataset(labelled_dataset)
    without_episodes(whole, [0], tmp_path / "left", None)
    before = json.loads((labelled_dataset / "navtool" / "labels.json").read_text())
    after = json.loads((tmp_path / "left" / "navtool" / "labels.json").read_text())
    assert after["config_hash"] == before["config_hash"]
    left = NavDataset(tmp_path / "left")
    for column in ("label.outcome", "label.known", "label.reason", "label.confidence", "stamp_ns"):
        np.testing.assert_array_equal(left.column(column), whole.column(column)[60:])
    assert after["failed_rows"] == int((left.column("label.outcome") == 0).sum()) > 0
    assert sum(after["reasons"].values()) == after["failed_rows"]
    relabelled = label_dataset(tmp_path / "left", LabelConfig())
    assert relabelled.rewritten == []
    assert (relabelled.negatives, relabelled.known_steps) == (after["negatives"], after["known_steps"])
    assert relabelled.reasons == after["reasons"]


def test_ingest_goes_on_with_what_was_made(recordings: list[Path], tmp_path: Path) -> None:
    ingested(recordings[:2], tmp_path / "two")
    without_episodes(NavDataset(tmp_path / "two"), [0], tmp_path / "left", None)
    again = ingested([recordings[1], recordings[2]], tmp_path / "left")
    assert [Path(path).stem for path in again.skipped] == ["run-1"]
    ingested([recordings[1], recordings[2]], tmp_path / "direct")
    assert hashes(tmp_path / "left") == hashes(tmp_path / "direct")


def test_what_does_not_go_together_is_refused(recordings: list[Path], tmp_path: Path) -> None:
    ingested(recordings[:1], tmp_path / "a")
    ingested(recordings[1:2], tmp_path / "slow", config=IngestConfig(fps=5))
    ingested(recordings[2:], tmp_path / "labelled")
    label_dataset(tmp_path / "labelled", LabelConfig())
    a, slow, labelled = (NavDataset(tmp_path / name) for name in ("a", "slow", "labelled"))
    out = tmp_path / "out"
    with pytest.raises(DatasetsError, match=r"ingest.fps is 5, 10 in"):
        together([a, slow], out, None)
    with pytest.raises(DatasetsError, match=r"run-0.* is in .*a too"):
        together([a, a], out, None)
    with pytest.raises(DatasetsError, match="labelled with other settings"):
        together([a, labelled], out, None)
    with pytest.raises(DatasetsError, match="no episode is left"):
        without_episodes(a, [0], out, None)
    with pytest.raises(DatasetsError, match="there is no episode 1, 4"):
        without_episodes(a, [0, 4, 1], out, None)
    with pytest.raises(DatasetsError, match="is there already"):
        together([a], tmp_path / "slow", None)
    assert not out.exists()


def test_an_interrupted_edit_leaves_nothing(recordings: list[Path], tmp_path: Path) -> None:
    ingested(recordings, tmp_path / "all")
    before = hashes(tmp_path / "all")
    counted: list[str] = []

    class Stop:
        def begin(self, things: int, work: int) -> None: ...
        def advance(self, done: int, spared: int) -> None: ...
        def done(self, _things: int, name: str) -> None:
            counted.append(name)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        without_episodes(NavDataset(tmp_path / "all"), [1], tmp_path / "left", Stop())
    assert len(counted) == 1
    assert not [path for path in tmp_path.iterdir() if "left" in path.name]
    without_episodes(NavDataset(tmp_path / "all"), [1], tmp_path / "left", None)
    assert len(NavDataset(tmp_path / "left").episodes) == 2
    assert hashes(tmp_path / "all") == before


def test_a_file_that_is_gone_is_no_fault_of_the_disk(labelled_dataset: Path, tmp_path: Path) -> None:
    shutil.copytree(labelled_dataset, tmp_path / "damaged")
    (video,) = (tmp_path / "damaged" / "videos").rglob("file-001.mp4")
    video.unlink()
    with pytest.raises(DatasetsError, match=r"file-001\.mp4: is not there\n.*navtool check"):
        without_episodes(NavDataset(tmp_path / "damaged"), [0], tmp_path / "out", None)
    assert not (tmp_path / "out").exists()


def test_provenance_is_read_a_few_times_an_episode(
    labelled_dataset: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    dataset = NavDataset(labelled_dataset)
    read: list[int] = []
    one = NavDataset.provenance_of

    def counted(self: NavDataset, episode: int) -> dict[str, Any]:
        read.append(episode)
        return one(self, episode)

    monkeypatch.setattr(NavDataset, "provenance_of", counted)
    without_episodes(dataset, [0], tmp_path / "out", None)
    assert sorted(read) == [1, 1, 2, 2]
