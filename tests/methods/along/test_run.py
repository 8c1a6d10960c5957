"""The one loop, with a tiny method: what every method gets for nothing."""

import csv
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from intensity_drive import intensity_drive
from noted import noted
from speed_profile import SpeedProfile, Speeds
from walking import walked

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.methods.along.observation import Observation, Skip
from navtool.methods.along.odometry import OdometryReading
from navtool.methods.along.report import TableReport
from navtool.methods.along.source import Input
from navtool.methods.table import METHODS, method_row

type Write = Callable[..., Path]


def profile(path: Path, out: Path, most_mps: float = 10.0) -> TableReport:
    return walked([Input(path)], SpeedProfile(most_mps), out)


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


@pytest.mark.parametrize("lidar", [True, False])
def test_a_method_that_needs_odometry_alone_works_with_and_without_a_lidar(
    write_recording: Write, tmp_path: Path, *, lidar: bool
) -> None:
    entries = [entry for entry in intensity_drive(turn_radps=0.25) if lidar or entry[0] != "/points"]
    report = profile(write_recording("mcap", entries), tmp_path / "out")
    assert report.ticks == report.results == sum(entry[0] == "/odom" for entry in entries)
    assert report.figures["most_mps"] == pytest.approx(0.5)
    assert report.files == {"lines": report.results}
    with (tmp_path / "out" / "results.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == report.results
    assert {float(line["forward_mps"]) for line in lines} == {0.5}
    assert set(files(tmp_path / "out")) == {"index.html", "lineage.json", "results.csv"}


@pytest.mark.parametrize("container", ["ros1", "db3", "mcap"])
def test_a_recording_and_its_data_set_give_the_same(write_recording: Write, tmp_path: Path, container: str) -> None:
    path = write_recording(container, intensity_drive(ros1=container == "ros1", turn_radps=0.25))
    ingest([path], tmp_path / "set", RobotConfig(), IngestConfig())
    ours, theirs = profile(path, tmp_path / "ours"), profile(tmp_path / "set", tmp_path / "theirs")
    assert replace(theirs, out=ours.out, seconds=ours.seconds) == ours
    one, two = files(tmp_path / "ours"), files(tmp_path / "theirs")
    assert one.pop("lineage.json") != two.pop("lineage.json")
    assert one == two


def test_what_is_skipped_is_counted_by_its_reason(write_recording: Write, tmp_path: Path) -> None:
    entries = intensity_drive()
    moving = [entry for entry in entries if entry[0] == "/odom"]
    for entry, speed_mps in zip(moving[3:6], (99.0, 88.0, float("nan")), strict=True):
        entry[3]["twist"]["twist"]["linear"]["x"] = speed_mps
    report = profile(write_recording("mcap", entries), tmp_path / "out")
    assert report.skipped == {"faster than robots go": 2, "not finite": 1}
    assert report.results == report.ticks - 3 == len(moving) - 3
    assert noted(report.notes, "speed.beyond-robots") == [f"odometry: 99 m/s at {moving[3][2]} ns"]


def test_again_it_is_done_and_otherwise_refused(write_recording: Write, tmp_path: Path) -> None:
    path, out = write_recording("mcap", intensity_drive()), tmp_path / "out"
    first = profile(path, out)
    before = files(out)
    again = profile(path, out)
    assert again == replace(first, done_before=True, seconds=0.0)
    assert files(out) == before
    with pytest.raises(DatasetsError, match="made with another"):
        profile(path, out, most_mps=5.0)


def test_a_recording_that_gives_nothing_leaves_nothing(write_recording: Write, tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive())
    with pytest.raises(DatasetsError, match=r"none of the \d+ poses gives a result: \d+ faster than robots go"):
        profile(path, tmp_path / "out", most_mps=0.1)
    still = write_recording("mcap", intensity_drive(odometry=False), name="still")
    with pytest.raises(DatasetsError, match="the recording has no odometry"):
        profile(still, tmp_path / "out")
    assert not list(tmp_path.glob("*out*"))


class Interrupted(SpeedProfile):
    """Is interrupted in the middle."""

    left = 30

    def step(self, observation: Observation[OdometryReading]) -> Speeds | Skip:
        self.left -= 1
        if not self.left:
            raise KeyboardInterrupt
        return super().step(observation)


def test_what_is_interrupted_leaves_nothing(write_recording: Write, tmp_path: Path) -> None:
    path = write_recording("mcap", intensity_drive())
    with pytest.raises(KeyboardInterrupt):
        walked([Input(path)], Interrupted(), tmp_path / "out")
    assert not list(tmp_path.glob("*out*"))
    assert profile(path, tmp_path / "out").results > Interrupted.left


def test_an_unknown_method_gets_the_known_ones_listed() -> None:
    with pytest.raises(DatasetsError, match="known are intensity_map, intensity_threshold"):
        method_row("intensity_mop")
    assert all(method_row(name) is row for name, row in METHODS.items())
