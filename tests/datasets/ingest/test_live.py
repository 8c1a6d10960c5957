"""Recordings that vanish, change or grow while they are read: an episode that passes the check, or a named reason."""

import re
import shutil
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from few_messages import file_of
from hashes import hashes

from navtool.base.progress import Silent
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.ingest.segment_step import segment_step
from navtool.datasets.robot.config import RobotConfig

Write = Callable[..., Path]
Drive = Callable[..., Any]
CONTAINERS = ("ros1", "ros1_lz4", "db3", "mcap_small_chunks")
SHARES = (0.0, 0.04, 0.2, 0.6, 0.8)
"""Shares of the work, of which planning is the first eighth."""


class Meddler(Silent):
    """Does something once a share of the work is done."""

    def __init__(self, share: float, action: Callable[[], object]) -> None:
        self.done_so = False
        self._share, self._action, self._left = share, action, 0.0

    def begin(self, _things: int, work: int) -> None:
        self._left = self._share * work

    def advance(self, done: int, _spared: int) -> None:
        self._left -= done
        if self._left <= 0 and not self.done_so:
            self.done_so = True
            self._action()


def ingested(path: Path, out: Path, watch: Silent | None = None) -> IngestReport:
    """The report; there is a data set that passes the check, or a reason and no folder."""
    report = ingest([path], out, RobotConfig(), IngestConfig(), progress=watch)
    assert len(report.episodes) + len(report.quarantined) + len(report.skipped) == 1
    if out.exists():
        checked = check_dataset(out)
        assert checked.passed, checked.findings
    else:
        assert report.quarantined[0].reason
    return report


@pytest.mark.parametrize(
    "container", [pytest.param(name, marks=() if name == "ros1" else pytest.mark.slow) for name in CONTAINERS]
)
def test_a_recording_that_vanishes_is_told(
    container: str, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    whole = write_recording(container, drive_entries(ros1=container.startswith("ros1")), "whole")
    told = []
    for number, share in enumerate(SHARES):
        path = tmp_path / f"{number}{whole.suffix}"
        (shutil.copy if whole.is_file() else shutil.copytree)(whole, path)
        meddler = Meddler(share, path.unlink if path.is_file() else _remover(path))
        report = ingested(path, tmp_path / f"out-{number}", meddler)
        assert meddler.done_so or report.episodes
        told += [entry.reason for entry in report.quarantined]
    assert told
    assert all(re.search("[Nn]o such file|are missing", reason) for reason in told), told


def _remover(path: Path) -> Callable[[], object]:
    return lambda: shutil.rmtree(path)


@pytest.mark.parametrize("container", ["ros1", "mcap_small_chunks"])
def test_a_recording_that_is_replaced_between_its_readings_is_told(
    container: str, write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    entries = drive_entries(ros1=container.startswith("ros1"))
    path = write_recording(container, entries, "one")
    later = [(topic, kind, at + 5_000_000, fields) for topic, kind, at, fields in entries]
    other = write_recording(container, later, "other")
    fewer = write_recording(container, [entry for entry in entries if entry[0] != "/points"], "fewer")

    for number, replacement in enumerate((other, fewer)):
        original = path.read_bytes()

        def replace_and_read(*arguments: Any, by: Path = replacement) -> Any:
            shutil.copy(by, path)
            return segment_step(*arguments)

        monkeypatch.setattr("navtool.datasets.ingest.candidate.segment_step", replace_and_read)
        report = ingested(path, tmp_path / f"out-{number}")
        assert re.search("changed while it was read|no topic /points", report.quarantined[0].reason)
        path.write_bytes(original)


def grow(path: Path, share: float, folder: Path) -> None:
    """Ingest a recording that is written on once a share of the work is done, and again when it is whole."""
    recorder = _sqlite_recorder(path) if path.is_dir() else _plain_recorder(path)
    next(recorder)
    meddler = Meddler(share, lambda: next(recorder))
    out = folder / "out"
    first = ingested(path, out, meddler)
    assert meddler.done_so
    assert next(recorder, None) is None
    again = ingested(path, out)
    assert not again.quarantined
    if first.episodes:
        assert again.episodes[0].rebuilt
    ingested(path, folder / "fresh")
    assert hashes(out) == hashes(folder / "fresh")


@pytest.mark.parametrize("container", ["ros1", "db3"])
def test_a_recording_that_grows_becomes_what_it_is_in_the_end(
    container: str, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    grow(write_recording(container, drive_entries(3.0, ros1=container == "ros1")), 0.04, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("share", SHARES)
@pytest.mark.parametrize("container", CONTAINERS)
def test_it_does_so_whenever_it_grows(
    container: str, share: float, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    grow(write_recording(container, drive_entries(3.0, ros1=container.startswith("ros1"))), share, tmp_path)


def test_a_database_is_known_by_its_log_too(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    folder = write_recording("db3", drive_entries())
    recorder = _sqlite_recorder(folder)
    next(recorder)
    file, out = file_of(folder), tmp_path / "out"
    before = ingested(file, out).episodes[0].rows
    next(recorder)
    grown = ingested(file, out).episodes[0]
    assert grown.rebuilt
    assert grown.rows > before
    assert ingested(file, out).skipped


def _plain_recorder(path: Path) -> Iterator[str]:
    """Cuts the file where a recorder may be, and writes the rest."""
    data = path.read_bytes()
    cut = len(data) * 3 // 5
    path.write_bytes(data[:cut])
    yield "begun"
    with path.open("ab") as file:
        file.write(data[cut:])
    yield "grown"


def _sqlite_recorder(folder: Path) -> Iterator[str]:
    """Takes the later messages out, and puts them back through the write-ahead log of an open database.

    A recorder is another process: it writes from whatever thread of this one meddles.
    """
    with closing(sqlite3.connect(file_of(folder), check_same_thread=False)) as database:
        database.execute("PRAGMA journal_mode = WAL")
        (middle,) = database.execute("SELECT MAX(id) * 3 / 5 FROM messages").fetchone()
        rest = database.execute("SELECT * FROM messages WHERE id > ?", (middle,)).fetchall()
        database.execute("DELETE FROM messages WHERE id > ?", (middle,))
        database.commit()
        yield "begun"
        for at in range(0, len(rest), 50):
            database.executemany("INSERT INTO messages VALUES (?, ?, ?, ?)", rest[at : at + 50])
            database.commit()
        yield "grown"
