"""Which definition a message is read by, and what a missing or broken one costs."""

import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest
from imu_and_twist import EPOCH_NS, IMU, imu_entries, split_recording, stamped

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import ImuSample, StringSample
from navtool.datasets.recording import open_recording

type Write = Callable[..., Path]


STRING = "std_msgs/msg/String"


def test_types_without_a_decoder_are_listed_and_hinder_nothing(container: str, write_recording: Write) -> None:
    odd = ("/odd", "sensor_msgs/msg/RelativeHumidity", EPOCH_NS, stamped(EPOCH_NS - 1))
    with open_recording(write_recording(container, [odd, *imu_entries(1)])) as recording:
        assert [topic.name for topic in recording.topics] == ["/imu", "/odd"]
        imu, other = sorted(recording.messages(["/odd", "/imu"]))
        assert isinstance(recording.decode(imu), ImuSample)
        assert recording.header_stamp_ns(other) == EPOCH_NS - 1
        with pytest.raises(
            DatasetsError, match=rf"/odd \(sensor_msgs/msg/RelativeHumidity\) at {EPOCH_NS} ns: there is"
        ):
            recording.decode(other)


def test_old_type_names_are_normalised(write_recording: Write) -> None:
    folder = write_recording("db3", imu_entries(1))
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("UPDATE topics SET type = 'sensor_msgs/Imu'")
        database.execute("UPDATE message_definitions SET topic_type = 'sensor_msgs/Imu'")
    database.close()
    with open_recording(folder) as recording:
        (raw,) = recording.messages(["/imu"])
        assert raw.type == recording.topics[0].type == IMU
        assert isinstance(recording.decode(raw), ImuSample)


def test_a_definition_in_the_recording_wins_over_the_bundled_one(write_recording: Write) -> None:
    folder = write_recording("db3", [("/note", STRING, EPOCH_NS, {"data": "hello"})])
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute(
            "UPDATE message_definitions SET encoded_message_definition = 'uint32 length\nuint8[5] bytes\nstring data'"
        )
        database.execute("UPDATE messages SET data = ?", (b"\0\1\0\0" + b"\5\0\0\0hello\0\0\0" + b"\3\0\0\0ok\0",))
    database.close()
    with open_recording(folder) as recording:
        sample = recording.decode(next(recording.messages(["/note"])))
        assert isinstance(sample, StringSample)
        assert sample.value == "ok"


def test_a_type_defined_nowhere_is_listed_and_only_its_decoding_fails(write_recording: Write) -> None:
    folder = write_recording("db3", [("/note", STRING, EPOCH_NS + 1, {"data": "hello"}), *imu_entries(1)])
    with sqlite3.connect(folder / "bag.db3") as database:
        database.execute("UPDATE topics SET type = 'lost_msgs/msg/Lost' WHERE name = '/note'")
    database.close()
    with open_recording(folder) as recording:
        imu, lost = recording.messages(["/note", "/imu"])
        assert isinstance(recording.decode(imu), ImuSample)
        assert recording.header_stamp_ns(lost) is None
        with pytest.raises(DatasetsError, match="no decoder"):
            recording.decode(lost)


@pytest.mark.parametrize(
    "text",
    [
        "%$",
        "std_msgs/Header header\nuint8 more",
        f"std_msgs/Header header\n{'=' * 80}\nMSG: std_msgs/Header\nuint32 seq",
        f"more_msgs/Rest rest\n{'=' * 80}\nMSG: more_msgs/Rest\nmore_msgs/Lost[] lost",
        f"more_msgs/Rest rest\n{'=' * 80}\nMSG: more_msgs/Rest\nmore_msgs/Rest[] rests",
    ],
    ids=["no definition", "header not defined", "header without a stamp", "a part not defined", "a part in itself"],
)
def test_a_broken_definition_hinders_only_its_own_topic(text: str, write_recording: Write) -> None:
    folder = write_recording("db3", [("/note", STRING, EPOCH_NS + 1, {"data": "hello"}), *imu_entries(1)])
    with sqlite3.connect(folder / "bag.db3") as database:
        broken = "UPDATE message_definitions SET encoded_message_definition = ? WHERE topic_type = ?"
        database.execute(broken, (text, IMU))
    database.close()
    with open_recording(folder) as recording:
        imu, note = recording.messages(["/note", "/imu"])
        assert isinstance(recording.decode(note), StringSample)
        assert recording.header_stamp_ns(imu) is None
        assert recording.layout_of(imu) is None
        with pytest.raises(DatasetsError, match=r"/imu .*its definition cannot be read"):
            recording.decode(imu)


def test_one_type_name_with_two_layouts_on_a_topic_is_refused_to_decode(write_recording: Write, tmp_path: Path) -> None:
    parts = [
        write_recording("db3", [("/note", STRING, EPOCH_NS + k, {"data": "hello"})], name=f"p{k}") / f"p{k}.db3"
        for k in range(2)
    ]
    same = split_recording(tmp_path / "same", parts, metadata=True)
    for file, text in ((same / "run_1.db3", "# a remark\nstring data"), (parts[1], "string data\nuint8 more")):
        with sqlite3.connect(file) as database:
            database.execute("UPDATE message_definitions SET encoded_message_definition = ?", (text,))
        database.close()
    with open_recording(same) as recording:
        assert [type(recording.decode(raw)) for raw in recording.messages(["/note"])] == [StringSample] * 2
    other = split_recording(tmp_path / "other", parts, metadata=True)
    with open_recording(other) as recording, pytest.raises(DatasetsError, match="two different types"):
        recording.decode(next(recording.messages(["/note"])))
