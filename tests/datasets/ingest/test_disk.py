"""A disk that is full or read-only at the worst moment: one clear error, and the data set is as it was, or complete."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from disk_factory import SmallDisk
from hashes import hashes

from navtool.base.errors import OutputError
from navtool.base.files import move
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store import journal
from navtool.datasets.store.reader import NavDataset

MEBIBYTES = 40
Mount = Callable[[int], SmallDisk]


class Stopped(BaseException):
    """The process ends here."""


@pytest.fixture
def bags(write_recording: Callable[..., Path], drive_entries: Callable[..., Any]) -> list[Path]:
    return [write_recording("mcap", drive_entries(2.0, seed=number), f"run-{number}") for number in range(2)]


def ingested(bags: list[Path], out: Path) -> IngestReport:
    report = ingest(bags, out, RobotConfig(), IngestConfig())
    assert not report.quarantined
    return report


@pytest.mark.parametrize("calls", [1, 3])
def test_a_disk_that_fills_during_a_commit_costs_that_episode_alone(
    calls: int, bags: list[Path], small_disk: Mount, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = small_disk(MEBIBYTES)
    out = disk.place / "out"
    ingested(bags[:1], out)
    before = hashes(out)
    left = calls

    def fill_and_move(source: Path, target: Path) -> None:
        nonlocal left
        left -= 1
        if left == 0:
            disk.fill()
        move(source, target)

    monkeypatch.setattr("navtool.datasets.store.writer.move", fill_and_move)
    with pytest.raises(OutputError, match="No space left on device"):
        ingested(bags, out)
    assert left <= 0
    assert hashes(out) == before, "before there is any space again"
    assert check_dataset(out).passed
    disk.free()
    assert ingested(bags, out).episodes[0].episode == 1
    ingested(bags, tmp_path / "whole")
    assert hashes(out) == hashes(tmp_path / "whole")


@pytest.mark.parametrize("interrupted", [False, True])
def test_a_disk_that_fills_during_the_replay_of_a_journal_costs_nothing(
    interrupted: bool, bags: list[Path], small_disk: Mount, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = small_disk(MEBIBYTES)
    out = disk.place / "out"
    ingested(bags[:1], out)
    ingested(bags, tmp_path / "whole")

    def fill(done: int) -> None:
        disk.fill()
        if interrupted and done == 1:
            raise Stopped

    monkeypatch.setattr(
        "navtool.datasets.store.writer.commit", lambda root, targets: journal.commit(root, targets, fill)
    )
    if interrupted:
        with pytest.raises(Stopped):
            ingested(bags, out)
        assert journal.journal_path(out).exists()
    else:
        ingested(bags, out)
    assert len(NavDataset(out).episodes) == 2, "replaying needs no space"
    assert check_dataset(out).passed
    disk.free()
    assert hashes(out) == hashes(tmp_path / "whole")


def test_a_read_only_output_is_one_clear_error_and_can_be_read(
    bags: list[Path], small_disk: Mount, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    disk = small_disk(MEBIBYTES)
    out = disk.place / "out"
    ingested(bags[:1], out)
    before = hashes(out)
    disk.remount("ro")
    for target in (out, disk.place / "new"):
        with pytest.raises(OutputError, match="Read-only file system"):
            ingested(bags, target)
    assert hashes(out) == before
    assert check_dataset(out).passed
    disk.remount("rw")

    def stop(done: int) -> None:
        if done == 1:
            raise Stopped

    with monkeypatch.context() as patch:
        patch.setattr("navtool.datasets.store.writer.commit", lambda root, targets: journal.commit(root, targets, stop))
        with pytest.raises(Stopped):
            ingested(bags, out)
    disk.remount("ro")
    with pytest.raises(OutputError, match="Read-only file system"):
        NavDataset(out)
    disk.remount("rw")
    assert ingested(bags, out).skipped == [f"{tmp_path.name}/run-0", f"{tmp_path.name}/run-1"]
    assert check_dataset(out).passed
