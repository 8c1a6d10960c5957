"""How far ingest says it is: up to the end and not beyond, whatever becomes of the recordings."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import IngestReport
from navtool.datasets.ingest.segment_step import segment_step
from navtool.datasets.robot.config import RobotConfig

Write = Callable[..., Path]
Drive = Callable[..., Any]
PLANNED = 2 / 16
"""The share of a recording's work that a dry run does."""
SMALL = ("odometry", "imu", "joints", "command", "tf")


class Watch:
    """Holds what it is told against the promise; remembers how far the work was at each moment."""

    def __init__(self) -> None:
        self.work = self.total = self.counted = self.finished = 0
        self.shares = [0.0]

    def begin(self, _things: int, work: int) -> None:
        assert self.work == 0
        self.work = self.total = work

    def advance(self, done: int, spared: int) -> None:
        assert min(done, spared) >= 0
        self.counted += done
        self.total -= spared
        assert self.counted <= self.total
        self.shares.append(self.counted / self.total if self.total else 1.0)
        assert self.shares[-1] >= self.shares[-2]

    def done(self, things: int, _name: str) -> None:
        self.finished += 1
        assert things == self.finished


def watched(paths: list[Path], out: Path, **options: Any) -> tuple[Watch, IngestReport]:
    """An ingest whose count ends at its total, with one thing done a recording."""
    watch = Watch()
    report = ingest(paths, out, RobotConfig(), options.pop("config", IngestConfig()), progress=watch, **options)
    assert watch.work > 0
    assert watch.counted == watch.total
    assert watch.finished == len(paths)
    return watch, report


@pytest.fixture
def short_segments(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("navtool.datasets.ingest.segment.TICKS_PER_SEGMENT", 16)


@pytest.mark.usefixtures("short_segments")
def test_every_container_is_counted_whole(
    container: str, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    path = write_recording(container, drive_entries(2.0, ros1="ros1" in container))
    watch, report = watched([path], tmp_path / "out")
    assert report.episodes
    assert watch.counted == watch.work, "nothing of a new recording with frames and clouds is spared"
    jumps = np.diff(watch.shares)
    assert jumps.max() < 0.15, "the bar moves in small steps"
    again, report = watched([path], tmp_path / "out")
    assert report.skipped
    assert again.counted == again.work // 16, "a recording that is there is hashed and no more"
    dry, _ = watched([path], tmp_path / "elsewhere", dry_run=True)
    assert dry.counted == dry.work == watch.work * PLANNED


@pytest.mark.parametrize("workers", [1, 2])
@pytest.mark.usefixtures("short_segments")
def test_whatever_becomes_of_the_recordings_the_count_ends_at_its_total(
    workers: int, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    first = write_recording("mcap_zstd", drive_entries(2.0, seed=1), name="a")
    small = write_recording("mcap", drive_entries(2.0, seed=2, streams=SMALL), name="b")
    cut = write_recording("mcap_no_summary", drive_entries(2.0, seed=3), name="c")
    cut.write_bytes(cut.read_bytes()[: cut.stat().st_size * 2 // 3])
    text = tmp_path / "d.bag"
    text.write_text("no recording")
    imu = write_recording("ros1_lz4", drive_entries(2.0, streams=("imu",), ros1=True), name="e")
    empty = tmp_path / "f.mcap"
    empty.touch()
    last = write_recording("ros1", drive_entries(2.0, seed=5, ros1=True), name="g")
    every = [first, small, cut, text, imu, empty, last]
    again: list[dict[str, bool]] = [{}, {"dry_run": True}] if workers == 1 else []
    for options in ({"dry_run": True}, {}, *again, {"allow_missing": True}):
        _, report = watched(every, tmp_path / "out", workers=workers, **options)
        refused = {Path(entry.path).name for entry in report.quarantined}
        # an IMU alone lacks what the others have
        assert refused >= {"d.bag", "f.mcap"} | (set() if options.get("allow_missing") else {"e.bag"})
    assert len(report.skipped) == 3
    assert [episode.source.rpartition("/")[2] for episode in report.episodes] == ["b", "e.bag"]


@pytest.mark.usefixtures("short_segments")
def test_a_second_reading_that_fails_is_counted_as_far_as_it_came(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rich = write_recording("mcap", drive_entries(seed=1), name="a")
    poor = write_recording("mcap", drive_entries(seed=2, streams=("camera", "odometry", "command")), name="b")

    def fail_on_a(path: Path, *rest: Any) -> Any:
        result = segment_step(path, *rest)
        if path.stem == "a":
            raise DatasetsError("the second reading failed")
        return result

    monkeypatch.setattr("navtool.datasets.ingest.candidate.segment_step", fail_on_a)
    # The second recording is planned for the first one's contents, and again once that has failed.
    _, report = watched([rich, poor], tmp_path / "out", allow_missing=True)
    assert [entry.reason for entry in report.quarantined] == ["the second reading failed"]
    assert report.episodes


def test_half_of_the_frames_and_clouds_are_read_when_half_of_the_work_is_told(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Reading frames and clouds is what takes the time: the clock of this test ticks with each of them."""
    clock: list[float] = []
    watch = Watch()

    def ticking(path: Path, segment: Any, config: Any, staged: Path, meter: Any) -> Any:
        part = meter.part

        def timed(*arguments: Any) -> Callable[[int], None]:
            reached = part(*arguments)

            def tick(place: int) -> None:
                reached(place)
                clock.append(watch.shares[-1])

            return tick

        meter.part = timed
        return segment_step(path, segment, config, staged, meter)

    monkeypatch.setattr("navtool.datasets.ingest.candidate.segment_step", ticking)
    paths = [write_recording("mcap_zstd", drive_entries(4.0, seed=n), name=f"run-{n}") for n in range(4)]
    ingest(paths, tmp_path / "out", RobotConfig(), IngestConfig(), progress=watch)
    even = (np.arange(len(clock)) + 1) / len(clock)
    assert np.abs(np.array(clock) - even).max() < 0.08
    assert np.interp(0.5, even, clock) < 2 / 3
