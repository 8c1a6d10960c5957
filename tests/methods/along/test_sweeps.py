"""Sweeps of a recording and of its data set are the same; tilted sensors, moving robots, bad points."""

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from intensity_drive import HEIGHT_M, START_NS, intensity_drive
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.setting_error import SettingError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.clock import Clock
from navtool.datasets.streams.config import SyncConfig
from navtool.methods.along.observation import Skip
from navtool.methods.along.source import EpisodeError, Input
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import Sweep, SweepConfig, Sweeps


class Seen(NamedTuple):
    """What the sweeps of an input are from, and what gave none."""

    streams: Streams
    clouds: int
    duration_s: float
    skipped: Counter[str]
    notes: list[Note]


def recorded(
    path: Path, robot: RobotConfig | None = None, sync: SyncConfig | None = None, **config: Any
) -> tuple[list[Sweep], Seen]:
    ticks = Sweeps(SweepConfig(**config))
    with Input(path, robot=robot or RobotConfig(), sync=sync or SyncConfig()).open() as source:
        streams = source.streams(ticks.reads, 0.25)
        read = [reading.read() for reading in ticks.readings(streams)]
        skips = [one for one in read if isinstance(one, Skip)]
        notes = [*streams.notes, *(one.note for one in skips if one.note is not None)]
        counted = Counter(one.reason for one in skips)
        seen = Seen(streams, ticks.count(streams), ticks.duration_s(streams), counted, notes)
        return [one for one in read if isinstance(one, Sweep)], seen


@pytest.mark.parametrize("container", ["ros1", "db3", "mcap"])
def test_a_recording_and_its_data_set_give_the_same_sweeps(
    write_recording: Callable[..., Path], tmp_path: Path, container: str
) -> None:
    path = write_recording(container, intensity_drive(ros1=container == "ros1", rpy_rad=(0.1, -0.2, 0.3)))
    report = ingest([path], tmp_path / "set", RobotConfig(), IngestConfig())
    assert not report.quarantined
    sweeps, source = recorded(path)
    stored, other = recorded(tmp_path / "set")
    assert len(sweeps) == len(stored) == source.clouds == other.clouds > 5
    ours, theirs = source.streams, other.streams
    assert (ours.name, ours.topics, source.duration_s) == (theirs.name, theirs.topics, other.duration_s)
    assert ours.lidar_height_m == theirs.lidar_height_m == pytest.approx(HEIGHT_M)
    for one, two in zip(sweeps, stored, strict=True):
        assert one.stamp_ns == two.stamp_ns
        assert one.xyz.tobytes() == two.xyz.tobytes()
        assert one.intensity.tobytes() == two.intensity.tobytes()
        assert one.odom_sensor is not None
        np.testing.assert_array_equal(one.odom_sensor, two.odom_sensor)


def test_clouds_that_were_ingested_by_record_time_are_walked_by_it(
    write_recording: Callable[..., Path], tmp_path: Path
) -> None:
    path = write_recording("mcap", intensity_drive())
    sync = SyncConfig()
    sync.lidar.clock = Clock.record
    ingest([path], tmp_path / "set", RobotConfig(), IngestConfig(sync=sync))
    sweeps, _ = recorded(path, sync=sync)
    stored, _ = recorded(tmp_path / "set")
    by_header, _ = recorded(path)
    assert [one.stamp_ns for one in sweeps] == [one.stamp_ns for one in stored]
    assert all(ours.stamp_ns - theirs.stamp_ns == 2_000_000 for ours, theirs in zip(sweeps, by_header, strict=True))
    assert all(ours.xyz.tobytes() == theirs.xyz.tobytes() for ours, theirs in zip(sweeps, stored, strict=True))


def test_a_tilted_sensor_sees_what_a_level_one_sees(write_recording: Callable[..., Path]) -> None:
    level, _ = recorded(write_recording("mcap", intensity_drive(), name="level"))
    tilted, _ = recorded(write_recording("mcap", intensity_drive(rpy_rad=(0.1, -0.2, 0.3)), name="tilted"))
    for ours, theirs in zip(level, tilted, strict=True):
        np.testing.assert_allclose(ours.xyz, theirs.xyz, atol=2e-5)
        np.testing.assert_array_equal(ours.odom_sensor, theirs.odom_sensor)


def test_a_moving_robot_sees_a_wall_where_it_is_at_the_stamp(write_recording: Callable[..., Path]) -> None:
    path = write_recording("mcap", intensity_drive(speed_mps=2.0, turn_radps=0.5))
    still, _ = recorded(path)
    moved, _ = recorded(path, deskew=False)

    def off_the_wall(sweep: Sweep) -> float:
        """How far the points of the wall at x = 4 m of the odometry lie from it."""
        assert sweep.odom_sensor is not None
        x, _, yaw = sweep.odom_sensor.tolist()
        return float(np.abs(np.cos(yaw) * sweep.xyz[:, 0] - np.sin(yaw) * sweep.xyz[:, 1] + x - 4.0).max())

    assert max(map(off_the_wall, still)) < 2e-3
    assert max(map(off_the_wall, moved)) > 0.1


def test_points_that_are_none_are_left_out_and_counted(write_recording: Callable[..., Path]) -> None:
    bad = [(np.nan, 0, 0, 9), (np.inf, 1, 1, 9), (0, 0, 0, 9), (1, 1, 1, np.nan), (0.1, 0.1, 0, 9)]
    path = write_recording("mcap", intensity_drive(bad=bad))
    clean, _ = recorded(write_recording("mcap", intensity_drive(), name="clean"))
    for ours, theirs in zip(recorded(path)[0], clean, strict=True):
        np.testing.assert_array_equal(ours.xyz, theirs.xyz)
        assert ours.drops == (3, 1, 1)
    assert recorded(path, robot_radius_m=0.0)[0][0].drops.own_body == 0


def test_clouds_that_give_no_sweep_are_counted(write_recording: Callable[..., Path]) -> None:
    entries = intensity_drive()
    clouds = [number for number, entry in enumerate(entries) if entry[0] == "/points"]
    for number, change in (
        (clouds[2], {"width": 0, "row_step": 0, "data": np.zeros(0, np.uint8)}),
        (clouds[4], {"data": np.zeros(7, np.uint8)}),
        (clouds[5], {"fields": entries[clouds[5]][3]["fields"][:3]}),
    ):
        topic, kind, record_ns, fields = entries[number]
        entries[number] = (topic, kind, record_ns, {**fields, **change})
    sweeps, source = recorded(write_recording("mcap", entries))
    assert source.skipped == {"empty": 1, "cannot be decoded": 1, "without intensities": 1}
    assert len(sweeps) == source.clouds - 3
    assert noted(source.notes, "cloud.undecodable")


def test_without_odometry_sweeps_have_no_place(write_recording: Callable[..., Path]) -> None:
    sweeps, source = recorded(write_recording("mcap", intensity_drive(odometry=False)))
    assert all(sweep.odom_sensor is None for sweep in sweeps)
    assert noted(source.notes, "odometry.none-to-walk-by")


def test_the_place_of_the_sensor_is_that_of_its_mount(write_recording: Callable[..., Path]) -> None:
    sweeps, _ = recorded(write_recording("mcap", intensity_drive(speed_mps=1.0, turn_radps=0.3, forward_m=0.5)))
    for sweep in sweeps:
        yaw = 0.3 * (sweep.stamp_ns - START_NS) * 1e-9
        way = 1.0 / 0.3 * np.array([np.sin(yaw), 1 - np.cos(yaw)])
        expected = [*(way + 0.5 * np.array([np.cos(yaw), np.sin(yaw)])), yaw]
        assert sweep.odom_sensor is not None
        np.testing.assert_allclose(sweep.odom_sensor, expected, atol=1e-4)


def test_the_height_is_unknown_where_nothing_tells_it(write_recording: Callable[..., Path]) -> None:
    path = write_recording("mcap", intensity_drive(footprint=False))
    assert recorded(path)[1].streams.lidar_height_m is None
    robot = replace(RobotConfig(), base_height_m=0.2)
    assert recorded(path, robot)[1].streams.lidar_height_m == pytest.approx(HEIGHT_M)


def test_a_recording_without_clouds_is_refused(write_recording: Callable[..., Path]) -> None:
    path = write_recording("mcap", [entry for entry in intensity_drive() if entry[0] != "/points"])
    with pytest.raises(DatasetsError, match=r"no point clouds.*/odom \(nav_msgs/msg/Odometry\)"):
        recorded(path)


def test_an_episode_that_is_not_there_is_refused(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    entries = intensity_drive()
    ingest([write_recording("mcap", entries)], tmp_path / "set", RobotConfig(), IngestConfig())
    with pytest.raises(EpisodeError, match="no episode 3: the data set has 1"), Input(tmp_path / "set", 3).open():
        raise AssertionError("there is no such episode")
    blind = [entry for entry in entries if entry[0] != "/points"]
    ingest([write_recording("mcap", blind, name="blind")], tmp_path / "blind-set", RobotConfig(), IngestConfig())
    with pytest.raises(DatasetsError, match="no whole clouds"):
        recorded(tmp_path / "blind-set")


@pytest.mark.parametrize(
    ("setting", "fault"),
    [
        ({"robot_radius_m": -1.0}, "0 keeps all"),
        ({"odometry_gap_s": 0.0}, "outside"),
        ({"robot_radius_m": 9.0}, r"outside \[0, 5\] m"),
    ],
)
def test_settings_out_of_range_are_refused(setting: dict[str, Any], fault: str) -> None:
    with pytest.raises(SettingError, match=fault):
        SweepConfig(**setting)


def test_a_place_beyond_all_maps_is_none(write_recording: Callable[..., Path]) -> None:
    entries = intensity_drive()
    for topic, _, _, fields in entries:
        if topic == "/odom":
            fields["pose"]["pose"]["position"]["x"] += 1e9
    sweeps, _ = recorded(write_recording("mcap", entries))
    assert sweeps
    assert all(sweep.odom_sensor is None for sweep in sweeps)
