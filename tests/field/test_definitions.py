"""Messages with bytes behind their last field, and definitions that lack a standard type, through to the rows."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from edited import lengthened, redefined
from ingesting import ingested
from noted import noted
from rosbags import rosbag1
from rosbags.typesys import Stores, get_typestore

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import open_recording

STREAMS = ("odometry", "imu", "camera")
IMU = "sensor_msgs/msg/Imu"
type Make = Callable[..., Any]


def rows_of(recording: Path, out: Path) -> tuple[Any, list[Any]]:
    """The columns of an ingested recording, and its notes."""
    report = ingested([recording], out)
    assert not report.quarantined, report.quarantined
    (data,) = out.glob("data/*/*.parquet")
    return pq.read_table(data), report.episodes[0].notes


@pytest.mark.parametrize("more", [4, 16])
def test_bytes_behind_the_last_field_are_left_and_counted(
    more: int, drive_entries: Make, recording_writer: Make, tmp_path: Path
) -> None:
    entries = drive_entries(1.0, streams=STREAMS)
    right, _ = rows_of(recording_writer(tmp_path, "db3", entries, "right"), tmp_path / "right-rows")
    longer = lengthened(recording_writer(tmp_path, "db3", entries, "longer"), more)
    rows, notes = rows_of(longer, tmp_path / "rows")
    assert rows.equals(right)
    left = noted(notes, "message.bytes-left")
    assert f"/imu/data: {more} bytes behind the last field of 100 messages are not read" in left
    assert any(note.startswith(f"/camera/image_raw/compressed: {more} bytes") for note in left)


def test_a_definition_that_lacks_a_standard_type_is_completed(
    drive_entries: Make, recording_writer: Make, tmp_path: Path
) -> None:
    entries = drive_entries(1.0, streams=("odometry", "imu"))
    right, _ = rows_of(recording_writer(tmp_path, "db3", entries, "right"), tmp_path / "right-rows")
    bare = recording_writer(tmp_path, "db3", entries, "bare")
    redefined(bare, IMU, lambda text: text.partition("=" * 20)[0])
    rows, notes = rows_of(bare, tmp_path / "rows")
    assert rows.equals(right)
    assert any("std_msgs/msg/Header" in note for note in noted(notes, "definition.completed"))


def old_bag(path: Path, change: Callable[[str], str], md5sum: str | None = None) -> Path:
    """A ROS 1 bag of ten IMU messages whose definition is another text, with the checksum of the standard one."""
    store = get_typestore(Stores.ROS1_NOETIC)
    text, right = store.generate_msgdef(IMU, ros_version=1)
    types = store.types
    with rosbag1.Writer(path) as writer:
        connection = writer.add_connection("/imu", IMU, msgdef=change(text), md5sum=md5sum or right)
        for k in range(10):
            stamp = types["builtin_interfaces/msg/Time"](5, k)
            header = types["std_msgs/msg/Header"](k, stamp, "imu")
            vector = types["geometry_msgs/msg/Vector3"](0.0, 0.0, float(k))
            turn = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            message = types[IMU](header, turn, np.zeros(9), vector, np.zeros(9), vector, np.zeros(9))
            writer.write(connection, 5_000_000_000 + k, store.serialize_ros1(message, IMU))
    return path


@pytest.mark.parametrize(
    "change",
    [
        lambda text: text.replace("MSG: std_msgs/Header", "MSG: roslib/Header"),
        lambda text: text.replace("std_msgs/Header", "Header").replace("MSG: Header", "MSG: roslib/Header"),
        lambda text: text.replace("std_msgs/Header", "roslib/Header"),
        lambda text: text.partition("=" * 20)[0],
        lambda _: "%$",
    ],
    ids=["roslib within", "plain name", "roslib throughout", "only its own fields", "nothing that can be read"],
)
def test_bags_from_before_2011_are_read_by_the_standard_definition(
    change: Callable[[str], str], tmp_path: Path
) -> None:
    with open_recording(old_bag(tmp_path / "old.bag", change)) as recording:
        samples: list[Any] = [recording.decode(raw) for raw in recording.messages(["/imu"])]
        assert [sample.angular_velocity[2] for sample in samples] == list(range(10))
        assert [sample.stamp_ns for sample in samples] == [5_000_000_000 + k for k in range(10)]


def test_a_checksum_that_is_not_the_standards_is_not_believed(tmp_path: Path) -> None:
    path = old_bag(tmp_path / "other.bag", lambda text: text.partition("=" * 20)[0], md5sum="0" * 32)
    with open_recording(path) as recording, pytest.raises(DatasetsError, match="it lacks that of"):
        recording.decode(next(recording.messages(["/imu"])))
