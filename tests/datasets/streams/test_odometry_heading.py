"""An odometry whose body looks aside: turned by the robot's setting, and told of where it has none."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.odometry_heading import heading_notes, turned_odometry
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.rows import ODOMETRY_COLUMNS
from navtool.datasets.streams.timed_stream import TimedStream, motion_of
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import rpy_from_transform

SECONDS = 12.0
angles = st.floats(-np.pi, np.pi)


def driven(
    course_rad: float,
    body_rad: float,
    *,
    speed_mps: float = 1.0,
    measured_rad: float | None = None,
    noise_m: float = 0.0,
) -> TimedStream:
    """A drive along a course while the odometry's body looks elsewhere.

    Args:
        course_rad: Where the robot goes, in the odometry's frame.
        body_rad: Where x of the odometry's body looks, from the course; 0 is forward.
        measured_rad: Where the velocity points in the body; None measures none.
    """
    time_s = np.arange(0, SECONDS, 0.05)
    noise = np.random.default_rng(1).normal(0, noise_m, (time_s.size, 2))
    along = speed_mps * time_s[:, None] * [np.cos(course_rad), np.sin(course_rad)] + noise
    values = np.zeros((time_s.size, len(ODOMETRY_COLUMNS)))
    values[:, :2] = along
    values[:, 3:7] = Rotation.from_euler("z", course_rad + body_rad).as_quat()
    if measured_rad is not None:
        values[:, 7:9] = speed_mps * np.array([np.cos(measured_rad), np.sin(measured_rad)])
    return stream(time_s, values)


def stream(time_s: Array, values: Array) -> TimedStream:
    recorded = RecordedStream("/odom", rows=[tuple(row) for row in values.tolist()], columns=ODOMETRY_COLUMNS)
    stamps_ns = np.rint(time_s * 1e9).astype(np.int64)
    return TimedStream.of(recorded, StreamTime(stamps_ns, np.arange(stamps_ns.size), "header"))


@given(roll=st.floats(-1, 1), pitch=st.floats(-1, 1), yaw=angles, turn=angles)
def test_the_yaw_is_added_in_the_body_frame(roll: float, pitch: float, yaw: float, turn: float) -> None:
    attitude = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    values = np.arange(2.0 * len(ODOMETRY_COLUMNS)).reshape(2, -1)
    values[:, 3:7] = attitude.as_quat()
    recorded = stream(np.arange(2.0), values)
    turned = turned_odometry(recorded, turn).values
    wanted = attitude * Rotation.from_euler("z", turn)
    np.testing.assert_allclose(Rotation.from_quat(turned[:, 3:7]).as_matrix()[0], wanted.as_matrix(), atol=1e-12)
    np.testing.assert_array_equal(np.delete(turned, range(3, 7), axis=1), np.delete(values, range(3, 7), axis=1))
    np.testing.assert_array_equal(recorded.values, values, err_msg="what was recorded is changed")


def test_attitudes_that_were_never_set_stay_so() -> None:
    recorded = stream(np.arange(3.0), np.zeros((3, len(ODOMETRY_COLUMNS))))
    np.testing.assert_array_equal(turned_odometry(recorded, 1.0).values, recorded.values)


@given(course=angles, body=angles)
def test_clouds_are_compensated_for_a_motion_forward(course: float, body: float) -> None:
    motion = motion_of(turned_odometry(driven(course, body), -body), 0.25)
    assert motion is not None
    moments = np.array([2_000_000_000, 3_000_000_000])
    poses = motion.relative_to(1_000_000_000, moments)
    assert poses is not None
    np.testing.assert_allclose(poses[:, :3, 3], [[1, 0, 0], [2, 0, 0]], atol=1e-9)
    np.testing.assert_allclose(rpy_from_transform(poses), 0, atol=1e-9)


@given(course=angles, body=angles)
def test_what_a_note_says_is_lacking_ends_it(course: float, body: float) -> None:
    recorded = driven(course, body)
    notes = heading_notes(recorded)
    aside = abs(np.sin(body)) > abs(np.cos(body)) + 1e-9
    along = abs(np.cos(body)) > abs(np.sin(body)) + 1e-9
    assert aside or not any(along for _ in notes), "a robot that moves along is told of"
    if aside:
        (note,) = notes
        lacking_rad = float(note.text.rpartition(" ")[2])
        assert lacking_rad == pytest.approx(-body, abs=1e-3)
        assert heading_notes(turned_odometry(recorded, lacking_rad)) == []


def test_little_travel_says_nothing_and_a_noisy_stand_neither() -> None:
    assert heading_notes(None) == []
    assert heading_notes(driven(0.0, -np.pi / 2, speed_mps=4.0 / SECONDS)) == []
    assert heading_notes(driven(0.0, -np.pi / 2, speed_mps=0.0, noise_m=0.02)) == []
    (note,) = heading_notes(driven(0.0, -np.pi / 2, noise_m=0.02))
    assert "moves 90 deg to the left of where its poses look" in note.text


def test_a_velocity_that_points_aside_is_told() -> None:
    assert heading_notes(driven(0.3, 0.0, measured_rad=0.0)) == []
    (note,) = heading_notes(driven(0.3, 0.0, measured_rad=-np.pi / 2))
    assert note.text.startswith("state: the measured velocity points 90 deg to the right")


@pytest.mark.parametrize("measured", [True, False], ids=["twists", "poses-alone"])
def test_a_drive_straight_on_runs_along_x(
    measured: bool, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    def aside(fields: dict[str, Any]) -> dict[str, Any]:
        """The drive along world y, of a body whose x looks to the robot's right: its yaw is 0."""
        position = fields["pose"]["pose"]["position"]
        pose = fields["pose"]["pose"] | {"position": {"x": 7.0, "y": position["x"], "z": 0.0}}
        return fields | {"pose": {"pose": pose}} | ({} if measured else {"twist": {}})

    entries = [
        (topic, kind, time, aside(fields) if topic == "/odom" else fields)
        for topic, kind, time, fields in drive_entries(2.0, streams=("odometry", "imu"), crash=False)
    ]
    path = write_recording("ros1" if measured else "mcap", entries)
    robot = RobotConfig(odometry_yaw_rad=np.pi / 2)
    ingest([path], tmp_path / "out", robot, IngestConfig())
    dataset = NavDataset(tmp_path / "out")
    pose = dataset.column("observation.pose")
    np.testing.assert_allclose(pose[:, 0], np.arange(len(pose)) * 0.1, atol=1e-5)
    np.testing.assert_allclose(pose[:, 1:], 0, atol=1e-5)
    np.testing.assert_allclose(dataset.column("observation.state"), [[1.0, 0.0]] * len(pose), atol=1e-4)
    native = dataset.stream(0, "odometry")
    assert native is not None
    yaw_rad = Rotation.from_quat(np.column_stack([native[name] for name in ("qx", "qy", "qz", "qw")])).as_euler("xyz")
    np.testing.assert_allclose(yaw_rad[:, 2], np.pi / 2, atol=1e-9)
