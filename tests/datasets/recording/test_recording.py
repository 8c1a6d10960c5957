"""Every container gives back what was written into it: topics, order, bytes, stamps."""

import shutil
import sqlite3
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from imu_and_twist import EPOCH_NS, IMU, TWIST, all_messages, imu_entries, mixed_entries, split_recording, stamped

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import ImuSample, TwistSample
from navtool.datasets.recording import RawMessage, RecordingFormat, open_recording

IMAGE = "sensor_msgs/msg/Image"
type Write = Callable[..., Path]


def test_a_recording_describes_itself(container: str, write_recording: Write) -> None:
    path = write_recording(container, mixed_entries())
    with open_recording(path) as recording:
        assert recording.path == path
        assert recording.format.value == {"ro": "ros1", "db": "ros2_db3", "mc": "mcap"}[container[:2]]
        assert [(x.name, x.type, x.count) for x in recording.topics] == [("/cmd_vel", TWIST, 3), ("/imu", IMU, 30)]
        assert recording.message_count == 33
        assert (recording.start_ns, recording.end_ns) == (EPOCH_NS, EPOCH_NS + 29 * 10**7)


def test_messages_come_in_the_order_of_record_times_with_their_contents(container: str, write_recording: Write) -> None:
    path = write_recording(container, mixed_entries())
    with open_recording(path) as recording:
        raws = list(recording.messages(["/imu", "/cmd_vel"]))
        assert [(x.topic, x.type, x.record_ns) for x in raws] == [entry[:3] for entry in mixed_entries()]
        for raw, (_, kind, record_ns, fields) in zip(raws, mixed_entries(), strict=True):
            sample = recording.decode(raw)
            if kind == IMU:
                assert isinstance(sample, ImuSample)
                assert sample.angular_velocity[0] == fields["angular_velocity"]["x"]
                assert sample.frame_id == "base"
                assert recording.header_stamp_ns(raw) == sample.stamp_ns == record_ns - 3 * 10**6
            else:
                assert isinstance(sample, TwistSample)
                assert sample.linear[0] == fields["linear"]["x"]
                assert recording.header_stamp_ns(raw) is sample.stamp_ns is None


def test_only_the_topics_asked_for_are_read(container: str, write_recording: Write) -> None:
    path = write_recording(container, mixed_entries())
    with open_recording(path) as recording:
        assert {x.topic for x in recording.messages(["/cmd_vel"])} == {"/cmd_vel"}
        assert list(recording.messages([])) == []
        with pytest.raises(DatasetsError, match=r"no topic /nope(.|\n)*/cmd_vel, /imu"):
            recording.messages(["/imu", "/nope"])


def test_two_readings_at_once_do_not_disturb_each_other(container: str, write_recording: Write) -> None:
    path = write_recording(container, mixed_entries())
    with open_recording(path) as recording:
        once = [raw.data for raw in recording.messages(["/imu"])]
        first, second = recording.messages(["/imu"]), recording.messages(["/imu"])
        pairs = [(next(first).data, next(second).data) for _ in range(30)]
        assert pairs == [(data, data) for data in once]


def test_late_writes_are_sorted_by_record_time(containers: tuple[str, ...], write_recording: Write) -> None:
    entries = mixed_entries()
    shuffled = [entries[(k * 7) % len(entries)] for k in range(len(entries))]
    for container in containers:
        path = write_recording(container, shuffled, name=container)
        assert [x.record_ns for x in all_messages(path)] == [entry[2] for entry in entries], container


def test_a_portion_of_time_is_read_alone(container: str, write_recording: Write) -> None:
    entries = mixed_entries()
    times = [entry[2] for entry in entries]
    with open_recording(write_recording(container, entries)) as recording:
        topics = {topic.name for topic in recording.topics}
        first, last = times[5], times[-8]
        portion = list(recording.messages(topics, first, last))
        assert [x.record_ns for x in portion] == [moment for moment in times if first <= moment <= last]
        assert [x.record_ns for x in recording.messages(topics, last)] == [x for x in times if x >= last]
        assert recording.faults == ()


def test_an_empty_recording_is_no_fault(container: str, write_recording: Write) -> None:
    with open_recording(write_recording(container, [])) as recording:
        assert (recording.message_count, recording.start_ns, recording.end_ns, recording.topics) == (0, 0, 0, ())
        assert list(recording.messages([])) == []


def test_a_header_stamp_of_zero_is_zero_and_not_none(container: str, write_recording: Write) -> None:
    with open_recording(write_recording(container, [("/imu", IMU, EPOCH_NS, {})])) as recording:
        (raw,) = recording.messages(["/imu"])
        assert recording.header_stamp_ns(raw) == 0


def test_the_byte_order_of_the_encapsulation_counts(write_recording: Write, cdr: Callable[..., bytes]) -> None:
    fields = {**stamped(EPOCH_NS + 123), "angular_velocity": {"z": 0.5}}
    with open_recording(write_recording("mcap", imu_entries(1))) as recording:
        for little_endian in (True, False):
            raw = RawMessage("/imu", IMU, EPOCH_NS, cdr(IMU, fields, little_endian=little_endian))
            assert recording.header_stamp_ns(raw) == EPOCH_NS + 123
            sample = recording.decode(raw)
            assert isinstance(sample, ImuSample)
            assert sample.angular_velocity.tolist() == [0.0, 0.0, 0.5]


def test_a_recording_is_closed_after_its_context(container: str, write_recording: Write) -> None:
    path = write_recording(container, mixed_entries())
    with open_recording(path) as recording:
        begun = recording.messages(["/imu"])
    with pytest.raises(DatasetsError, match="closed"):
        recording.messages(["/imu"])
    with pytest.raises(DatasetsError):
        next(begun)


def test_a_folder_is_read_like_its_file(write_recording: Write) -> None:
    for container, suffix in (("db3", "db3"), ("mcap", "mcap"), ("mcap_message", "mcap"), ("db3_file", "db3.zstd")):
        folder = write_recording(container, mixed_entries(), name=container)
        assert all_messages(folder / f"{container}.{suffix}") == all_messages(folder)


def test_a_killed_recorders_folder_has_no_description_and_is_read_all_the_same(write_recording: Write) -> None:
    folder = write_recording("db3", mixed_entries())
    expected = all_messages(folder)
    (folder / "metadata.yaml").unlink()
    assert all_messages(folder) == expected


@pytest.mark.parametrize("metadata", [True, False])
@pytest.mark.parametrize(("container", "count"), [("db3", 2), ("mcap", 12)])
def test_the_parts_of_a_split_recording_are_one(
    container: str, count: int, metadata: bool, write_recording: Write, tmp_path: Path
) -> None:
    entries = [entry for k in range(count) for entry in imu_entries(2, EPOCH_NS + k * 10**9)]
    parts = [
        write_recording(container, entries[2 * k : 2 * k + 2], name=f"p{k}") / f"p{k}.{container}" for k in range(count)
    ]
    folder = split_recording(tmp_path / "run", parts, metadata)
    with open_recording(folder) as recording:
        assert recording.message_count == 2 * count
        assert (recording.start_ns, recording.end_ns) == (entries[0][2], entries[-1][2])
        assert [x.record_ns for x in recording.messages(["/imu"])] == [entry[2] for entry in entries]


def test_parts_that_overlap_are_merged_by_record_time(write_recording: Write, tmp_path: Path) -> None:
    entries = imu_entries(20)
    parts = [write_recording("mcap", entries[k::2], name=f"p{k}") / f"p{k}.mcap" for k in range(2)]
    with open_recording(split_recording(tmp_path / "run", parts, metadata=True)) as recording:
        assert [x.record_ns for x in recording.messages(["/imu"])] == [entry[2] for entry in entries]


def test_a_part_is_not_read_before_its_time(write_recording: Write, tmp_path: Path) -> None:
    parts = [
        write_recording("mcap", imu_entries(2, EPOCH_NS + k * 10**9), name=f"p{k}") / f"p{k}.mcap" for k in range(2)
    ]
    folder = split_recording(tmp_path / "run", parts, metadata=True)
    with open_recording(folder) as recording:
        stream = recording.messages(["/imu"])
        (folder / "run_1.mcap").write_bytes(b"")
        assert [x.record_ns for x in stream] == [EPOCH_NS, EPOCH_NS + 10**7]
        assert "run_1.mcap: 1 of 1 chunks skipped" in recording.faults[0]


def listing(folder: Path) -> list[tuple[str, int, int]]:
    return sorted((str(x), x.stat().st_size, x.stat().st_mtime_ns) for x in folder.rglob("*"))


def test_a_database_in_write_ahead_mode_is_read_without_leaving_files(write_recording: Write) -> None:
    folder = write_recording("db3", mixed_entries())
    file = folder / "bag.db3"
    with sqlite3.connect(file) as database:
        assert database.execute("PRAGMA journal_mode=WAL").fetchone() == ("wal",)
    database.close()
    before = listing(folder)
    assert len(all_messages(folder)) == 33
    assert listing(folder) == before


def test_what_a_killed_recorder_left_in_the_write_ahead_log_is_read(write_recording: Write, tmp_path: Path) -> None:
    file = write_recording("db3", imu_entries(3)) / "bag.db3"
    database = sqlite3.connect(file)
    database.execute("PRAGMA journal_mode=WAL")
    late = "INSERT INTO messages (topic_id, timestamp, data) SELECT topic_id, ?, data FROM messages"
    database.execute(late, (EPOCH_NS * 2,))
    database.commit()
    killed = tmp_path / "killed"
    killed.mkdir()
    for name in ("bag.db3", "bag.db3-wal"):
        shutil.copy(file.with_name(name), killed / name)
    database.close()
    before = listing(killed)
    assert [x.record_ns for x in all_messages(killed / "bag.db3")] == [
        *(entry[2] for entry in imu_entries(3)),
        *[EPOCH_NS * 2] * 3,
    ]
    assert listing(killed) == before


def test_a_link_to_a_database_is_read_like_the_database(write_recording: Write, tmp_path: Path) -> None:
    link = tmp_path / "link.db3"
    link.symlink_to(write_recording("db3", imu_entries(3)) / "bag.db3")
    assert len(all_messages(link)) == 3


def test_reading_holds_a_fraction_of_the_recording(container: str, write_recording: Write) -> None:
    pixels = np.zeros(300_000, np.uint8)
    images = [("/image", IMAGE, EPOCH_NS + k, {"height": 1, "width": 100_000, "data": pixels}) for k in range(40)]
    path = write_recording(container, images)
    with open_recording(path) as recording:
        tracemalloc.start()
        try:
            assert sum(len(raw.data) for raw in recording.messages(["/image"])) > 12_000_000
            _, peak = tracemalloc.get_traced_memory()
        finally:
            tracemalloc.stop()
    assert peak < 5_000_000


def test_the_first_schema_of_db3_has_no_definitions_and_no_index(write_recording: Write) -> None:
    folder = write_recording("db3", list(reversed(mixed_entries())))
    database = sqlite3.connect(folder / "bag.db3")
    for statement in (
        "DROP TABLE schema",
        "DROP TABLE metadata",
        "DROP TABLE message_definitions",
        "DROP INDEX timestamp_idx",
        "ALTER TABLE topics DROP COLUMN offered_qos_profiles",
        "ALTER TABLE topics DROP COLUMN type_description_hash",
    ):
        database.execute(statement)
    database.commit()
    database.close()
    with open_recording(folder) as recording:
        raws = list(recording.messages(["/imu", "/cmd_vel"]))
        assert [x.record_ns for x in raws] == [entry[2] for entry in mixed_entries()]
        assert isinstance(recording.decode(raws[0]), ImuSample)
        assert recording.header_stamp_ns(raws[0]) == EPOCH_NS - 3 * 10**6


def test_paths_with_the_signs_of_an_address_are_read(write_recording: Write) -> None:
    for container in ("db3", "mcap", "ros1"):
        path = write_recording(container, imu_entries(2), name=container)
        folder = path.parent / f"100%20 a#b?c=d {container}"
        folder.mkdir()
        assert len(all_messages(path.rename(folder / path.name))) == 2
        assert len(all_messages(folder / path.name)) == 2


def test_the_format_follows_from_the_bytes_and_not_from_the_name(write_recording: Write, tmp_path: Path) -> None:
    disguised = tmp_path / "recording.data"
    shutil.copy(write_recording("ros1", imu_entries(2)), disguised)
    with open_recording(disguised) as recording:
        assert recording.format is RecordingFormat.ros1
        assert recording.message_count == 2
