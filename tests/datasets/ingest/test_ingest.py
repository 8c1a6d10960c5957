"""Ingest as a whole: every container gives the same rows, nothing is lost unsaid, nothing half-written stays."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hashes import hashes
from ingesting import ingested
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.base.setting_error import SettingError
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig, TopicCandidates
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.writer import open_store

Write = Callable[..., Path]
Drive = Callable[..., list[Any]]


@pytest.mark.parametrize("container", ["ros1", "ros1_bz2", "ros1_lz4", "db3", "mcap", "mcap_zstd"])
def test_every_container_gives_the_same_rows(
    container: str, write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    reference = tmp_path / "reference"
    ingested([write_recording("mcap", drive_entries(), name="a")], reference)
    out = tmp_path / "out"
    report = ingested([write_recording(container, drive_entries(ros1=container.startswith("ros1")), name="b")], out)
    assert report.rows == 30
    expected, found = NavDataset(reference), NavDataset(out)
    assert expected.features == found.features
    for key, feature in expected.features.items():
        if feature.dtype != "video" and len(feature.shape) == 1:
            np.testing.assert_array_equal(expected.column(key), found.column(key), err_msg=key)
    for row in (0, 7, 29):
        np.testing.assert_array_equal(expected.points(row), found.points(row))
        np.testing.assert_array_equal(expected.image(row), found.image(row))


def test_values_are_those_of_the_drive(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    out = tmp_path / "out"
    report = ingested([write_recording("mcap", drive_entries(crash=False))], out)
    dataset = NavDataset(out)
    state, pose = dataset.column("observation.state"), dataset.column("observation.pose")
    valid = dataset.column("valid.state")
    assert valid.sum() >= 29
    np.testing.assert_allclose(state[valid], np.tile([1.0, 0.0], (valid.sum(), 1)), atol=1e-6)
    np.testing.assert_allclose(pose[valid, 0], np.arange(30)[valid] / 10, atol=1e-5)
    np.testing.assert_array_equal(dataset.column("action")[dataset.column("valid.action")][:, 0], 1.0)
    proprioception = dataset.column("observation.proprioception")[5]
    np.testing.assert_allclose(proprioception, [2.5, 5.0, 5.0, 10.0, 1.0, 2.0, 4.0], atol=1e-5)
    np.testing.assert_allclose(dataset.column("observation.imu")[5], [0, 0, 9.81, 0, 0, 0], atol=1e-5)
    assert np.diff(dataset.column("stamp_ns")).tolist() == [100_000_000] * 29
    np.testing.assert_allclose(dataset.column("sync.error_s.lidar")[:29], 0.02, atol=1e-6)
    assert (dataset.column("label.outcome") == 1).all()
    assert not dataset.column("label.known").any()
    # 45 frames at 15 Hz serve 30 ticks; every message is in a row or counted with a reason
    assert report.dropped == {
        "camera: another message is nearer to the tick": 14,
        "camera: outside the grid": 1,
    }
    assert check_dataset(out).passed


def test_a_battery_without_joints_is_a_column_of_its_own(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    report = ingested([write_recording("mcap", drive_entries(streams=("odometry", "battery")))], out)
    assert report.quarantined == []
    dataset = NavDataset(out)
    column = dataset.column("observation.proprioception")
    assert dataset.features["observation.proprioception"].names == ("battery_current_a",)
    np.testing.assert_array_equal(column[dataset.column("valid.battery")], [[4.0]] * 30)
    assert check_dataset(out).passed


def test_clouds_lie_in_the_robot_frame_in_front_and_whole_beside(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    ingested([write_recording("mcap", drive_entries())], out)
    dataset = NavDataset(out)
    counts = dataset.column("lidar.count")
    points = dataset.points(3)[: counts[3]]
    assert counts[3] > 100
    assert (points[:, 0] >= 0).all()
    assert points[:, 2].min() > -0.5 + 0.6 - 1e-3, "the lidar sits 0.6 m above the base"
    assert np.abs(points * 1000 - np.rint(points * 1000)).max() < 1e-2
    clouds = list(dataset.clouds(0))
    assert [cloud.frame_index for cloud in clouds] == list(range(30))
    assert all(len(cloud.xyz) == 600 for cloud in clouds)
    assert clouds[3].intensity is not None
    assert clouds[3].intensity.shape == (600,)
    imu = dataset.stream(0, "imu")
    assert imu is not None
    assert len(imu["stamp_ns"]) == 300
    assert (imu["record_ns"] - imu["stamp_ns"] == 3_000_000).all()


def test_the_same_input_gives_the_same_bytes(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    ingested([path], tmp_path / "first")
    ingested([path], tmp_path / "second")
    assert hashes(tmp_path / "first") == hashes(tmp_path / "second")


def test_later_commands_append_and_known_recordings_are_skipped(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    first = write_recording("mcap", drive_entries(seed=1), name="run-2")
    second = write_recording("mcap", drive_entries(seed=2), name="run-10")
    both, grown = tmp_path / "both", tmp_path / "grown"
    report = ingested([second, first], both)
    assert [episode.source.rsplit("/", 1)[1] for episode in report.episodes] == ["run-2", "run-10"]
    ingested([first], grown)
    again = ingested([first, second], grown)
    assert len(again.skipped) == 1
    assert again.rows == 30
    assert hashes(both) == hashes(grown)
    third = write_recording("mcap", drive_entries(seed=3), name="run-11")
    for paths in ([first], [third]):
        with pytest.raises(DatasetsError, match=r"voxel_m=0.05, asked for 0.2"):
            ingested(paths, grown, config=IngestConfig(voxel_m=0.2))
        with pytest.raises(DatasetsError, match=r"fps=10, asked for 5"):
            ingested(paths, grown, config=IngestConfig(fps=5))
    assert hashes(both) == hashes(grown)
    assert ingested([third], grown, config=IngestConfig(place="elsewhere")).rows == 30


def test_named_topics_are_not_replaced_by_guesses(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    robot = RobotConfig(topics=TopicCandidates(camera=["none"], lidar=["/absent"]))
    report = ingested([write_recording("mcap", drive_entries())], tmp_path / "out", robot=robot)
    episode = report.episodes[0]
    assert "camera" not in episode.topics
    assert "lidar" not in episode.topics
    assert "/absent" in noted(episode.notes, "topics.none-of-them")[0]
    assert {"/points", "/camera/image_raw/compressed"} <= {topic["name"] for topic in episode.not_used}


def test_one_writer_at_a_time(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    out = tmp_path / "out"
    ingested([path], out)
    with open_store(out), pytest.raises(DatasetsError, match="another process is writing"):
        ingested([path], out)


def test_rows_begin_with_the_first_measured_speed(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    entries = drive_entries()
    late = [entry for entry in entries if entry[0] != "/odom" or entry[2] - entries[0][2] > 450_000_000]
    out = tmp_path / "out"
    report = ingested([write_recording("mcap", late)], out)
    dataset = NavDataset(out)
    assert len(dataset) == 25
    assert dataset.column("valid.state").all()
    assert report.dropped["camera: outside the grid"] > 0
    frames = dataset.column("sync.error_s.camera")
    assert np.abs(frames).max() < 0.04, "the ticks keep the camera's phase"


def test_what_the_rows_have_no_column_for_is_kept_beside_them(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    first = write_recording("mcap", drive_entries(2.0, streams=("odometry",)), name="first")
    more = write_recording("mcap", drive_entries(2.0, seed=1, streams=("odometry", "lidar", "imu")), name="more")
    report = ingest([first, more], tmp_path / "out", RobotConfig(), IngestConfig())
    assert len(report.episodes) == 2
    assert noted(report.episodes[1].notes, "contents.left-out")[0].startswith("lidar, imu: ")
    dataset = NavDataset(tmp_path / "out")
    assert "lidar.count" not in dataset.features
    assert len(list(dataset.clouds(0))) == 0
    clouds = list(dataset.clouds(1))
    assert len(clouds) == 20
    assert all(len(cloud.xyz) == 600 for cloud in clouds)
    imu = dataset.stream(1, "imu")
    assert imu is not None
    assert len(imu["stamp_ns"]) == 200
    assert check_dataset(tmp_path / "out").passed


def test_the_place_of_an_episode_can_be_named_later(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    path = write_recording("mcap", drive_entries(2.0, streams=("odometry",)))
    ingest([path], tmp_path / "out", RobotConfig(), IngestConfig())
    named = ingest([path], tmp_path / "out", RobotConfig(), IngestConfig(place="campus"))
    assert len(named.skipped) == 1
    assert list(named.placed.values()) == ["campus"]
    assert NavDataset(tmp_path / "out").episodes[0].place == "campus"
    assert ingest([path], tmp_path / "out", RobotConfig(), IngestConfig(place="campus")).placed == {}
    (tmp_path / "forest").mkdir()
    (tmp_path / "forest" / "run.mcap").symlink_to(path)
    ingest([tmp_path / "forest" / "run.mcap"], tmp_path / "out", RobotConfig(), IngestConfig(place="{parent}"))
    assert NavDataset(tmp_path / "out").episodes[0].place == "forest", "the folder by which it is reached"
    with pytest.raises(SettingError, match=r"place: \{parnt\}"):
        IngestConfig(place="{parnt}")
