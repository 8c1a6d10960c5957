"""Odometry as other people's recordings have it: what its rows must hold, whatever its velocities say."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ingesting import ingested
from noted import noted
from odometry_drives import (
    ANGULAR,
    LINEAR,
    OdometryDrive,
    held,
    into_parent,
    odometry_drive,
    odometry_entries,
    scaled,
)

from navtool.datasets.check.run import check_dataset
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.store.reader import NavDataset
from navtool.pipeline.arrays import Array

type Write = Callable[..., Path]


def rows(dataset: NavDataset, drive: OdometryDrive) -> Array:
    """The true speed forward and turning rate of every row."""
    time_s = dataset.column("timestamp").ravel()
    return np.column_stack([np.interp(time_s, drive.time_s, part) for part in drive.truth[:, [0, 2]].T])


def ingest_one(path: Path, out: Path, **options: Any) -> tuple[NavDataset, list[Any]]:
    report = ingested([path], out, **options)
    assert not report.quarantined, report.quarantined
    return NavDataset(out), report.episodes[0].notes


@pytest.mark.parametrize("course", ["lap", "circle", "one-turn"])
@pytest.mark.parametrize("container", ["mcap", "ros1"])
def test_odom_world_twist(course: str, container: str, write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive(course, seconds=18.0)
    path = write_recording(container, odometry_entries(drive.spoilt(into_parent)))
    dataset, notes = ingest_one(path, tmp_path / "out")
    state = dataset.column("observation.state")
    np.testing.assert_allclose(state[:, 0], rows(dataset, drive)[:, 0], atol=0.05)
    np.testing.assert_allclose(state[:, 1], rows(dataset, drive)[:, 1], atol=0.05)
    assert len(noted(notes, "odometry.parent-twist")) == 1
    told = json.loads((dataset.layout.episode(0) / "sync.json").read_text())
    assert any("not in the robot's" in note for note in told["streams"]["odometry"]["notes"])


@pytest.mark.parametrize(("empty", "part"), [({"vx": 0}, "vx"), ({"wz": 0}, "wz")], ids=["no_linear", "no_angular"])
def test_odom_partial_twist(empty: dict[str, float], part: str, write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive("circle", seconds=8.0)
    path = write_recording("mcap", odometry_entries(drive.spoilt(scaled(**empty)), frame="camera_init"))
    dataset, notes = ingest_one(path, tmp_path / "out")
    np.testing.assert_allclose(dataset.column("observation.state"), rows(dataset, drive), atol=0.02)
    (note,) = noted(notes, "odometry.twist-part")
    assert part in note


def test_odom_twist_that_drops_out_and_poses_that_stop(write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive("mixed")
    everything = slice(LINEAR.start, ANGULAR.stop)
    spoilt = drive.spoilt(held(8.0, 12.0, everything, 0.0)).spoilt(held(20.0, 24.0, slice(0, 7)))
    dataset, notes = ingest_one(write_recording("mcap", odometry_entries(spoilt)), tmp_path / "out")
    valid, state = dataset.column("valid.state"), dataset.column("observation.state")
    time_s = dataset.column("timestamp").ravel()
    stopped = (time_s > 19.99) & (time_s < 24.01)
    np.testing.assert_array_equal(valid, ~stopped)
    np.testing.assert_allclose(state[valid], rows(dataset, drive)[valid], atol=0.03)
    assert "80 of 800 messages" in noted(notes, "odometry.twist-stale")[0].replace("81 of", "80 of")
    assert len(noted(notes, "odometry.poses-stopped")) == 1


def test_what_nothing_decides_is_a_warning_of_check_and_a_setting_ends_it(
    write_recording: Write, tmp_path: Path
) -> None:
    drive = odometry_drive("mixed")
    path = write_recording("mcap", odometry_entries(drive.spoilt(scaled(vx=1.5))))
    dataset, notes = ingest_one(path, tmp_path / "out")
    assert len(noted(notes, "odometry.twist-apart")) == 1
    np.testing.assert_allclose(dataset.column("observation.state")[:, 0], 1.5 * rows(dataset, drive)[:, 0], atol=0.03)
    told = [finding.message for finding in check_dataset(tmp_path / "out").findings if finding.check == "native"]
    assert any("1.50 times as large" in message for message in told)
    robot = RobotConfig(odometry_twist=OdometryTwist.from_poses)
    dataset, notes = ingest_one(path, tmp_path / "set", robot=robot)
    assert not noted(notes, "odometry.twist-apart")
    np.testing.assert_allclose(dataset.column("observation.state"), rows(dataset, drive), atol=0.03)
    assert not [x for x in check_dataset(tmp_path / "set").findings if x.check == "native"]


def test_sound_odometry_is_not_spoken_of(write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive("mixed", noise_m=0.005, noise_rad=0.002, noise_mps=0.02)
    _, notes = ingest_one(write_recording("mcap", odometry_entries(drive)), tmp_path / "out")
    assert not [note for note in notes if note.code.startswith(("odometry.", "state."))]
    assert not [x for x in check_dataset(tmp_path / "out").findings if x.check == "native"]
