"""Poses and calibrations of the robot file against those of the recording: which counts is told, and can be chosen."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ingesting import ingested
from noted import noted

from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.sensor_config import CameraFallback, Mounting
from navtool.datasets.store.reader import NavDataset

type Drive = Callable[..., list[Any]]
type Write = Callable[..., Path]

TURNED = [0.0, 0.0, 0.1]
LENS = CameraFallback(width=128, height=96, fx=100.0, fy=100.0, cx=64.0, cy=48.0)


@pytest.mark.parametrize("overrule", [False, True])
def test_tf_counts_unless_the_robot_file_overrules_it(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, overrule: bool
) -> None:
    path = write_recording("mcap", drive_entries(1.0))
    mounting = Mounting(xyz_m=[0.5, 0.0, 0.6], rpy_rad=TURNED, overrule=overrule)
    report = ingested([path], tmp_path / "out", robot=RobotConfig(mounting={"lidar": mounting}))
    (episode,) = report.episodes
    (told,) = noted(episode.notes, "mounting.overrules" if overrule else "mounting.not-used")
    assert "0.50 m and 6 degrees apart" in told
    assert ("mounting.lidar.overrule: true" in told) is not overrule
    pose = NavDataset(tmp_path / "out").calibration(0).base_lidar
    assert pose is not None
    assert pose[0, 3] == pytest.approx(0.5 if overrule else 0.0)
    assert np.allclose(pose, mounting.pose()) is overrule


def test_the_same_pose_written_twice_is_no_note(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    robot = RobotConfig(mounting={"lidar": Mounting(xyz_m=[0.0, 0.0, 0.6])})
    report = ingested([write_recording("mcap", drive_entries(1.0))], tmp_path / "out", robot=robot)
    assert not [note for note in report.episodes[0].notes if note.code.startswith("mounting.")]


@pytest.mark.parametrize("overrule", [False, True])
def test_camera_info_counts_unless_the_robot_file_overrules_it(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, overrule: bool
) -> None:
    robot = RobotConfig(camera=replace(LENS, overrule=overrule))
    report = ingested([write_recording("mcap", drive_entries(1.0))], tmp_path / "out", robot=robot)
    (told,) = noted(report.episodes[0].notes, "calibration.overrules" if overrule else "calibration.not-used")
    assert "fx = " in told
    calibration = NavDataset(tmp_path / "out").calibration(0)
    assert calibration.sources["camera"].startswith("robot" if overrule else "the recording's CameraInfo")
    assert calibration.camera is not None
    assert (calibration.camera.fx == pytest.approx(250.0)) is overrule
