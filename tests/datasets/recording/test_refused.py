"""What is no recording, or one of another kind: the error tells what, where and, if there is one, the cure."""

import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import mcap.writer
import numpy as np
import pytest
from few_messages import IMU, entries, file_of

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import RawMessage, open_recording

type Write = Callable[..., Path]


def test_what_is_not_there_is_reported(tmp_path: Path) -> None:
    with pytest.raises(DatasetsError, match="no such file or folder") as caught:
        open_recording(tmp_path / "absent.bag")
    assert caught.value.where == str(tmp_path / "absent.bag")
    assert caught.value.cure


def test_a_folder_without_a_recording(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("nothing here")
    with pytest.raises(DatasetsError, match=r"no recording in this folder(.|\n)*metadata.yaml|bag file"):
        open_recording(tmp_path)


def test_a_folder_with_several_recordings_lists_them(tmp_path: Path) -> None:
    for name in ("a.bag", "b.mcap"):
        (tmp_path / name).write_bytes(b"x")
    with pytest.raises(DatasetsError, match=r"holds 2 recordings, not one: a\.bag, b\.mcap"):
        open_recording(tmp_path)


def test_recordings_below_a_folder_are_named(tmp_path: Path) -> None:
    (tmp_path / "monday" / "run").mkdir(parents=True)
    (tmp_path / "monday" / "run" / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {relative_file_paths: [run_0.db3]}"
    )
    with pytest.raises(DatasetsError, match="not in this folder itself") as caught:
        open_recording(tmp_path)
    assert str(tmp_path / "monday" / "run") in str(caught.value.cure)
    for number in range(11):
        (tmp_path / "monday" / f"{number:02d}.bag.zstd").touch()
    with pytest.raises(DatasetsError, match=r"holds 12 recordings.*monday/00.bag.zstd, .* and 2 more") as caught:
        open_recording(tmp_path)
    assert "ingest" in str(caught.value.cure)


def png(path: Path) -> None:
    cv2.imwrite(str(path), np.zeros((4, 4, 3), np.uint8))


@pytest.mark.parametrize(
    ("write", "told"),
    [
        (lambda path: path.write_bytes(b""), "the file is empty"),
        (lambda path: path.write_text("just some text\n"), "this is not a recording"),
        (png, "this is not a recording"),
        (lambda path: path.write_bytes(b"#ROSBAG V1.2\n" + bytes(100)), "version 1.2 are not supported"),
        (lambda path: path.write_bytes(b"#ROSBAG V2.0\n"), "nothing in it can be read"),
        (lambda path: path.write_bytes(b"SQLite format 3\0" + bytes(100)), "db3 recording cannot be"),
        (lambda path: path.write_bytes(b"\x89MCAP0\r\n" + bytes(100)), "nothing in it can be read"),
        (lambda path: path.write_bytes(b"\x28\xb5\x2f\xfd" + b"\xff" * 100), "cannot be decompressed"),
        (lambda path: path.write_bytes(b"\x28\xb5\x2f\xfd" + bytes(100)), "truncated"),
    ],
)
def test_a_file_that_is_no_recording(write: Callable[[Path], None], told: str, tmp_path: Path) -> None:
    path = tmp_path / "file.png"
    write(path)
    with pytest.raises(DatasetsError, match=told) as caught:
        open_recording(path)
    assert str(caught.value.where).startswith(str(path))


def test_an_sqlite_database_of_something_else(tmp_path: Path) -> None:
    path = tmp_path / "contacts.db3"
    with sqlite3.connect(path) as database:
        database.execute("CREATE TABLE topics (id INTEGER)")
    database.close()
    with pytest.raises(DatasetsError, match=r"contacts\.db3: an SQLite database without the table messages"):
        open_recording(path)


def test_a_description_that_names_absent_files(write_recording: Write) -> None:
    folder = write_recording("mcap", entries())
    file_of(folder).unlink()
    with pytest.raises(DatasetsError, match=r"1 of the 1 files it lists are missing: bag\.mcap(.|\n)*cure"):
        open_recording(folder)


def test_parts_of_different_formats(write_recording: Write, tmp_path: Path) -> None:
    parts = [file_of(write_recording(container, entries(), name=container)) for container in ("db3", "mcap")]
    folder = tmp_path / "mixed"
    folder.mkdir()
    for part in parts:
        shutil.copy(part, folder / part.name)
    names = ", ".join(part.name for part in parts)
    (folder / "metadata.yaml").write_text(f"rosbag2_bagfile_information: {{relative_file_paths: [{names}]}}")
    with pytest.raises(DatasetsError, match="different formats: mcap, ros2_db3"):
        open_recording(folder)


def mcap_file(path: Path, message_encoding: str, schema_encoding: str, name: str = IMU) -> Path:
    """One message of bytes that are never read."""
    with path.open("wb") as stream:
        writer: Any = mcap.writer.Writer(stream)
        writer.start()
        schema = writer.register_schema(name, schema_encoding, b"{}")
        channel = writer.register_channel("/odd", message_encoding, schema)
        writer.add_message(channel, 5, b"{}", 5)
        writer.finish()
    return path


@pytest.mark.parametrize(
    ("message_encoding", "schema_encoding", "told"),
    [
        ("flatbuffer", "flatbuffer", "messages encoded as 'flatbuffer' are not supported yet"),
        ("json", "jsonschema", "the message cannot be decoded"),
        ("protobuf", "protobuf", "its definition cannot be read"),
        ("cdr", "omgidl2", "definitions written in 'omgidl2' are not supported yet"),
    ],
)
def test_other_serialisations_are_listed_and_refused_by_name(
    message_encoding: str, schema_encoding: str, told: str, tmp_path: Path
) -> None:
    with open_recording(mcap_file(tmp_path / "odd.mcap", message_encoding, schema_encoding)) as recording:
        assert [(topic.name, topic.count) for topic in recording.topics] == [("/odd", 1)]
        (raw,) = recording.messages(["/odd"])
        assert raw.data == b"{}"
        assert recording.header_stamp_ns(raw) is None
        with pytest.raises(DatasetsError, match=rf"/odd \(.*at 5 ns: {told}"):
            recording.decode(raw)


def test_an_unknown_chunk_compression(write_recording: Write) -> None:
    file = write_recording("mcap_lz4", entries())
    file.write_bytes(file.read_bytes().replace(b"\3\0\0\0lz4", b"\3\0\0\0lz9"))
    with pytest.raises(DatasetsError, match=r"nothing in it .*compression 'lz9' is not supported; lz4 and zstd are"):
        open_recording(file)


def test_an_unknown_chunk_compression_of_ros1(write_recording: Write) -> None:
    file = write_recording("ros1_lz4", entries())
    file.write_bytes(file.read_bytes().replace(b"compression=lz4", b"compression=lz9"))
    with pytest.raises(DatasetsError, match="chunk compression 'lz9' is not supported; bz2 and lz4 are"):
        open_recording(file)


def test_an_unknown_distribution(write_recording: Write) -> None:
    with pytest.raises(DatasetsError, match=r"'melodic'(.|\n)*humble, iron, jazzy"):
        open_recording(write_recording("mcap", entries()), ros_distro="melodic")


def test_a_message_of_another_recording_is_refused(write_recording: Write) -> None:
    with open_recording(write_recording("mcap", entries())) as recording:
        stranger = RawMessage("/elsewhere", IMU, 5, b"")
        with pytest.raises(DatasetsError, match="not one of this recording"):
            recording.decode(stranger)
