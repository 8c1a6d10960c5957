"""Segments, workers and rebuilt episodes: however the work is cut and shared, the data set is the same."""

import shutil
from collections.abc import Callable
from multiprocessing import active_children
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hashes import hashes
from ingesting import ingested

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.lineage import file_sha256
from navtool.base.progress import Silent
from navtool.base.workers import make_workers
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.segment_step import segment_step
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset

Write = Callable[..., Path]
Drive = Callable[..., Any]


def test_segments_join_to_the_same_rows(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_recording("mcap", drive_entries(5.0))
    ingested([path], tmp_path / "one")
    monkeypatch.setattr("navtool.datasets.ingest.segment.TICKS_PER_SEGMENT", 16)
    ingested([path], tmp_path / "many")
    one, many = NavDataset(tmp_path / "one"), NavDataset(tmp_path / "many")
    assert file_sha256(one.layout.data(0)) == file_sha256(many.layout.data(0))
    assert len(list((many.layout.episode(0) / "clouds").iterdir())) == 4
    for cloud, same in zip(one.clouds(0), many.clouds(0), strict=True):
        assert (cloud.stamp_ns, cloud.frame_index) == (same.stamp_ns, same.frame_index)
        assert np.array_equal(cloud.xyz, same.xyz)
    for row in (0, 15, 16, 17, 40, 49):
        difference = one.image(row).astype(int) - many.image(row).astype(int)
        assert np.abs(difference).mean() < 1.0
        np.testing.assert_array_equal(one.points(row), many.points(row))
    assert check_dataset(tmp_path / "many").passed


def test_any_number_of_workers_gives_the_same_bytes(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("navtool.datasets.ingest.segment.TICKS_PER_SEGMENT", 16)
    paths = [
        write_recording(kind, drive_entries(3.4, seed=n, ros1=kind == "ros1"), name=f"run-{n}")
        for n, kind in enumerate(("mcap", "ros1", "mcap"))
    ]
    text = tmp_path / "run-1b.bag"
    text.write_text("no recording")
    reports = {count: ingested([*paths, text], tmp_path / f"by-{count}", workers=count) for count in (1, 3)}
    assert hashes(tmp_path / "by-1") == hashes(tmp_path / "by-3")
    assert reports[1].to_json()["recordings"] == reports[3].to_json()["recordings"]
    assert [entry.path for entry in reports[3].quarantined] == [str(text)]
    again = ingested(paths, tmp_path / "by-3", workers=2)
    assert len(again.skipped) == 3
    assert hashes(tmp_path / "by-1") == hashes(tmp_path / "by-3")


def test_the_first_recording_may_fail_late_with_workers(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rich = write_recording("mcap", drive_entries(seed=1), name="a")
    poor = write_recording("mcap", drive_entries(seed=2, streams=("camera", "odometry", "command")), name="b")

    def fail_on_a(path: Path, *rest: Any) -> Any:
        if path.stem == "a":
            raise DatasetsError("the second reading failed")
        return segment_step(path, *rest)

    monkeypatch.setattr("navtool.datasets.ingest.candidate.segment_step", fail_on_a)
    monkeypatch.setattr("navtool.datasets.ingest.ingest.make_workers", lambda _, tell: make_workers(1, tell))
    report = ingested([rich, poor], tmp_path / "out", workers=2, allow_missing=True)
    assert [entry.reason for entry in report.quarantined] == ["the second reading failed"]
    dataset = NavDataset(tmp_path / "out")
    assert not dataset.description.contents.lidar, "the failed recording fixes nothing"
    assert dataset.episodes[0].source.endswith("/b")


def test_a_recording_that_changed_replaces_its_episode(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    first = write_recording("mcap", drive_entries(3.0, seed=1), name="run-1")
    second = write_recording("mcap", drive_entries(3.0, seed=2), name="run-2")
    grown = write_recording("mcap", drive_entries(4.0, seed=3), name="run-3")
    out = tmp_path / "out"
    ingested([first, second], out)
    shutil.rmtree(first)
    shutil.move(grown, first)
    report = ingested([first, second], out)
    assert [(episode.episode, episode.rebuilt) for episode in report.episodes] == [(0, True)]
    assert len(report.skipped) == 1
    ingested([first, second], tmp_path / "fresh")
    assert hashes(out) == hashes(tmp_path / "fresh")
    assert check_dataset(out).passed
    label_dataset(out, LabelConfig())
    # Another robot configuration makes another episode of the same recording.
    wide = RobotConfig(width_m=0.9)
    again = ingested([second], out, robot=wide)
    assert [(episode.episode, episode.rebuilt) for episode in again.episodes] == [(1, True)]
    assert not (out / "navtool" / "labels.json").exists(), "the labels have to be made again"
    assert NavDataset(out).calibration(1).robot_width_m == 0.9
    assert NavDataset(out).calibration(0).robot_width_m == 0.5


def test_runs_of_other_days_that_are_called_alike_replace_nothing(
    recording_writer: Callable[..., Path], drive_entries: Drive, tmp_path: Path
) -> None:
    paths = []
    for day in range(2):
        folder = tmp_path / f"day-{day}" / "bags"
        folder.mkdir(parents=True)
        later = [(topic, kind, at + day * 86_400 * 10**9, f) for topic, kind, at, f in drive_entries(seed=day)]
        paths.append(recording_writer(folder, "mcap", later, "run"))
    out = tmp_path / "out"
    report = ingested(paths, out)
    assert [(episode.source, episode.rebuilt) for episode in report.episodes] == [("bags/run", False)] * 2
    assert len(NavDataset(out).episodes) == 2
    assert ingested([paths[1]], out).skipped == ["bags/run"]


def test_a_worker_that_dies_ends_the_ingest_with_its_reason(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    class Killer(Silent):
        def advance(self, _done: int, _spared: int) -> None:
            for worker in active_children():
                worker.kill()

    paths = [write_recording("mcap", drive_entries(seed=n), name=f"run-{n}") for n in range(2)]
    with pytest.raises(OutputError, match="a worker process was ended"):
        ingested(paths, tmp_path / "out", workers=2, progress=Killer())
    assert not (tmp_path / "out").exists()
