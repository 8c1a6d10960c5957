"""A dry run tells what an ingest would do, and does nothing."""

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ingesting import ingested

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.journal import journal_path

type Drive = Callable[..., list[Any]]
type Write = Callable[..., Path]


def test_dry_run_writes_nothing(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    report = ingested([path], tmp_path / "out", dry_run=True)
    assert report.rows == 30
    assert not (tmp_path / "out").exists()


def test_a_dry_run_foretells_what_an_ingest_does(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    """Recordings against an existing data set: kept, moved elsewhere, rebuilt, refused, added, added twice."""
    sound, other = write_recording("mcap", drive_entries()), write_recording("mcap", drive_entries(seed=1), "grown")
    out, robot = tmp_path / "out", RobotConfig()
    ingested([sound, other], out)
    shutil.rmtree(other)
    write_recording("mcap", drive_entries(4.0, seed=1), "grown")
    blind = [entry for entry in drive_entries(seed=2) if "camera" not in entry[0]]
    new = write_recording("mcap", drive_entries(seed=3), "new")
    copy = shutil.copytree(new, tmp_path / "zz-copy")
    broken = tmp_path / "broken.mcap"
    broken.write_bytes(b"nothing")
    paths = [sound, other, write_recording("mcap", blind, "blind"), new, copy, broken]
    before = _state(out)
    config = IngestConfig(place="yard")
    planned = ingest(paths, out, robot, config, dry_run=True)
    assert _state(out) == before
    done = ingest(paths, out, robot, config)
    for report in (planned, done):
        assert len(report.skipped) == 2, "the sound one, and the second of two that are the same"
        assert [(episode.episode, episode.rebuilt) for episode in report.episodes] == [(1, True), (2, False)]
        assert [Path(entry.path).name for entry in report.quarantined] == ["blind", "broken.mcap"]
    assert planned.episodes_before == 2
    assert planned.placed == done.placed
    assert planned.quarantined == done.quarantined
    assert [episode.rows for episode in planned.episodes] == [episode.rows for episode in done.episodes]
    with pytest.raises(DatasetsError, match="the data set has fps=10, asked for 5"):
        ingest(paths, out, robot, IngestConfig(fps=5), dry_run=True)


def _state(folder: Path) -> dict[str, tuple[int, int]]:
    stats = {str(path): path.stat() for path in folder.rglob("*")}
    return {name: (stat.st_mtime_ns, stat.st_size) for name, stat in stats.items()}


def test_a_dry_run_for_a_new_data_set_takes_the_first_recording_for_all(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    blind = [entry for entry in drive_entries(seed=2) if "camera" not in entry[0]]
    paths = [write_recording("mcap", drive_entries(), "a"), write_recording("mcap", blind, "b")]
    out = tmp_path / "out"
    planned = ingest(paths, out, RobotConfig(), IngestConfig(), dry_run=True)
    assert not out.exists()
    assert [Path(entry.path).name for entry in planned.quarantined] == ["b"]
    assert "lacks camera" in planned.quarantined[0].reason


def test_a_dry_run_waits_for_no_interrupted_step(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path, out = write_recording("mcap", drive_entries()), tmp_path / "out"
    ingested([path], out)
    journal_path(out).write_text('{"files": ["meta/info.json"]}')
    with pytest.raises(DatasetsError, match="was interrupted"):
        ingested([path], out, dry_run=True)
    assert journal_path(out).exists()
