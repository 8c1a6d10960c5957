"""Odometry and mounts that are only on /tf."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ingesting import ingested
from noted import noted
from odometry_drives import OdometryDrive, odometry_drive, odometry_entries, transforms_entry

from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig, TopicCandidates
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.transform_edges import read_edges
from navtool.pipeline.arrays import Array

type Write = Callable[..., Path]
LEVEL = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
UP = [0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 1.0]


def moving(
    drive: OdometryDrive, parent: str, child: str, *further: tuple[str, str, Callable[[float], list[float]]], **how: Any
) -> list[Any]:
    """/tf with the drive's poses as one edge, and further edges over time."""
    return [
        transforms_entry(t, [(parent, child, pose), *((above, below, of(t)) for above, below, of in further)], **how)
        for t, pose in zip(drive.time_s.tolist(), drive.values[:, :7].tolist(), strict=True)
    ]


def the_drive(dataset: NavDataset, drive: OdometryDrive) -> None:
    time_s = dataset.column("timestamp").ravel()
    truth = np.column_stack([np.interp(time_s, drive.time_s, part) for part in drive.truth[:, [0, 2]].T])
    np.testing.assert_allclose(dataset.column("observation.state"), truth, atol=0.02)
    assert dataset.column("valid.state").all()
    steps = np.diff(dataset.column("observation.pose")[:, :2], axis=0)
    np.testing.assert_allclose(np.linalg.norm(steps, axis=1), 0.1 * np.abs(truth[:-1, 0] + truth[1:, 0]) / 2, atol=0.01)


def one(path: Path, out: Path, **options: Any) -> tuple[NavDataset, list[Any]]:
    report = ingested([path], out, **options)
    assert not report.quarantined, report.quarantined
    return NavDataset(out), report.episodes[0].notes


@pytest.mark.parametrize("container", ["mcap", "ros1"])
@pytest.mark.parametrize(
    ("parent", "child", "above"),
    [
        ("odom", "base_link", None),
        ("/odom", "/base_link", None),
        ("robot1/odom", "robot1/base_link", "robot1/map"),
        ("odom", "base_footprint", "map"),
        ("world", "base_link", None),
        ("camera_init", "body", None),
    ],
)
def test_tf_only_odometry(
    container: str, parent: str, child: str, above: str | None, write_recording: Write, tmp_path: Path
) -> None:
    drive = odometry_drive("mixed", seconds=12.0)
    # The localisation's edge jumps: it is no odometry.
    localised = [(above, parent, lambda t: [5.0 * (t > 6), 0, 0, 0, 0, 0, 1])] if above else []
    entries = moving(drive, parent, child, *localised, ros1=container == "ros1")
    dataset, notes = one(write_recording(container, entries), tmp_path / "out")
    the_drive(dataset, drive)
    (note,) = noted(notes, "odometry.from-tf")
    assert f"taken from {parent.lstrip('/')} -> {child.lstrip('/')} on /tf" in note
    assert (f"{above} -> {parent} is a localisation's" in note) == (above is not None)


def test_a_base_that_moves_in_its_footprint_is_put_together(write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive("circle", seconds=12.0)
    rises = ("base_footprint", "base_link", lambda t: [0.0, 0.0, 0.3 + 0.1 * np.sin(t), 0, 0, 0, 1])
    dataset, notes = one(write_recording("mcap", moving(drive, "odom", "base_footprint", rises)), tmp_path / "out")
    the_drive(dataset, drive)
    height = dataset.column("observation.pose")[:, 2]
    assert np.ptp(height) == pytest.approx(0.2, abs=0.02)
    assert "odom -> base_footprint, base_footprint -> base_link" in noted(notes, "odometry.from-tf")[0]


def test_edges_in_messages_of_their_own_at_their_own_rates(write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive("mixed", seconds=12.0)
    entries = [*moving(drive, "odom", "base_footprint")]
    entries += [
        transforms_entry(t + 0.013, [("base_footprint", "base_link", UP)]) for t in np.arange(0, 12, 0.5).tolist()
    ]
    entries += [
        transforms_entry(t + 0.017, [("base_link", "wheel", [0, 0, 0, 0, np.sin(t), 0, np.cos(t)])]) for t in range(12)
    ]
    dataset, _ = one(write_recording("mcap", sorted(entries, key=lambda entry: entry[2])), tmp_path / "out")
    the_drive(dataset, drive)


def test_a_robot_that_stands_has_odometry_too(write_recording: Write, tmp_path: Path) -> None:
    drive = odometry_drive("stand", seconds=5.0)
    dataset, _ = one(write_recording("mcap", moving(drive, "odom", "base_link")), tmp_path / "out")
    assert dataset.column("valid.state").all()
    assert not dataset.column("observation.state").any()


def test_a_topic_or_the_robot_file_comes_first(write_recording: Write, tmp_path: Path) -> None:
    drive, other = odometry_drive("circle", seconds=5.0), odometry_drive("straight", seconds=5.0)
    entries = sorted([*moving(other, "odom", "base_link"), *odometry_entries(drive)], key=lambda entry: entry[2])
    dataset, notes = one(write_recording("mcap", entries), tmp_path / "out")
    the_drive(dataset, drive)
    assert not noted(notes, "odometry.from-tf")
    alone = write_recording("mcap", moving(other, "odom", "base_link"), name="alone")
    report = ingested([alone], tmp_path / "none", robot=RobotConfig(topics=TopicCandidates(odometry=["none"])))
    assert len(report.quarantined) == 1


def test_other_frames_are_no_odometry(write_recording: Write, tmp_path: Path) -> None:
    turtles = moving(odometry_drive("circle", seconds=5.0), "world", "turtle1")
    report = ingested([write_recording("mcap", turtles)], tmp_path / "out")
    assert "no usable stream" in report.quarantined[0].reason


@pytest.mark.parametrize("container", ["mcap", "ros1"])
def test_static_on_tf(
    container: str, write_recording: Write, drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    """The same drive with its mounts on /tf_static, and on /tf, again and again."""
    ros1 = container == "ros1"
    entries = drive_entries(3.0, streams=("camera", "lidar", "odometry", "imu", "tf"), ros1=ros1)
    static = next(entry for entry in entries if entry[0] == "/tf_static")
    repeated = [("/tf", static[1], static[2] + 100_000_000 * k, static[3]) for k in range(25)]
    on_tf = sorted([*(entry for entry in entries if entry is not static), *repeated], key=lambda entry: entry[2])
    usual, _ = one(write_recording(container, entries, name="usual"), tmp_path / "out-usual")
    moved, notes = one(write_recording(container, on_tf, name="moved"), tmp_path / "out-moved")
    (note,) = noted(notes, "tf.mount-moving-topic")
    assert "base_link -> lidar" in note
    assert not noted(notes, "sensor.no-pose")
    for pose in ("base_camera", "base_lidar", "base_imu"):
        wanted, got = (getattr(dataset.calibration(0), pose) for dataset in (usual, moved))
        np.testing.assert_array_equal(got, wanted)
    np.testing.assert_array_equal(moved.points(3), usual.points(3))


def test_a_sensor_that_is_panned_has_no_mounting(
    write_recording: Write, drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    entries = [entry for entry in drive_entries(3.0, streams=("lidar", "odometry")) if entry[0] != "/tf_static"]
    first_s = (entries[0][2] - 1_700_000_000_000_000_000) * 1e-9
    panned = [
        transforms_entry(
            first_s + 0.1 * k, [("base_link", "lidar", [0, 0, 0.6, 0, 0, np.sin(0.1 * k), np.cos(0.1 * k)])]
        )
        for k in range(25)
    ]
    _, notes = one(write_recording("mcap", sorted([*entries, *panned], key=lambda entry: entry[2])), tmp_path / "out")
    assert len(noted(notes, "sensor.no-pose")) == 1
    assert not noted(notes, "tf.mount-moving-topic")


def test_nothing_is_read_of_moving_transforms_that_nothing_needs(
    write_recording: Write, drive_entries: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("navtool.datasets.streams.from_transforms.read_edges", lambda *_: pytest.fail("read"))
    entries = [*drive_entries(2.0), transforms_entry(2.5, [("odom", "base_link", LEVEL)])]
    one(write_recording("mcap", entries), tmp_path / "out")


@pytest.mark.parametrize("container", ["mcap", "ros1", "db3"])
def test_transforms_read_from_bytes_are_those_of_the_decoder(
    container: str, write_recording: Write, monkeypatch: pytest.MonkeyPatch
) -> None:
    drive = odometry_drive("mixed", seconds=2.0)
    odd = ("a", "some_longer_frame", lambda t: [t, 1, 2, 0, 0, 0, 1])
    path = write_recording(container, moving(drive, "/odom", "base_link", odd, ros1=container == "ros1"))
    with open_recording(path) as recording:
        fast = read_edges(recording, ["/tf"])
        monkeypatch.setattr("navtool.datasets.streams.transform_edges.TRANSFORMS_LAYOUT", {})
        slow = read_edges(recording, ["/tf"])
    assert list(fast) == list(slow) == [("odom", "base_link"), ("a", "some_longer_frame")]
    for edge, samples in fast.items():
        assert (samples.stamps_ns, samples.record_ns) == (slow[edge].stamps_ns, slow[edge].record_ns)
        sign = np.sign(samples.poses[:, 6:]) * np.sign(slow[edge].poses[:, 6:])
        np.testing.assert_allclose(samples.poses[:, :3], slow[edge].poses[:, :3])
        np.testing.assert_allclose(samples.poses[:, 3:] * sign, slow[edge].poses[:, 3:], atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "edge"), [("evo/tf_example.bag", "odom -> base_footprint"), ("evo/tf_example", "odom -> base_footprint")]
)
def test_a_real_recording_of_transforms_alone_becomes_a_data_set(
    name: str, edge: str, recordings: Path, tmp_path: Path
) -> None:
    dataset, notes = one(recordings / "bags" / name, tmp_path / "out")
    assert edge in noted(notes, "odometry.from-tf")[0]
    assert dataset.column("valid.state").mean() > 0.9


@pytest.mark.slow
def test_transforms_of_a_real_recording_give_the_motion_of_its_odometry(recordings: Path, tmp_path: Path) -> None:
    path = recordings / "bags/evo/nav2_turtlebot.mcap"
    topic, _ = one(path, tmp_path / "topic")
    edges = _from_tf(path)
    times: Array = np.frombuffer(edges["odom", "base_link"].stamps_ns, np.int64)
    native = topic.stream(0, "odometry")
    assert native is not None
    np.testing.assert_array_equal(times, native["stamp_ns"])
    np.testing.assert_allclose(edges["odom", "base_link"].poses[:, 0], native["x_m"], atol=1e-9)


def _from_tf(path: Path) -> Any:
    with open_recording(path) as recording:
        return read_edges(recording, ["/tf"])
