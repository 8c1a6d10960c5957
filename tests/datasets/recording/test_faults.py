"""Whatever is wrong with a recording: one kind of error that tells what, where and, if there is one, the cure."""

import sqlite3
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from few_messages import entries, file_of, read_all

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import StringSample
from navtool.datasets.recording import RawMessage, open_recording

type Write = Callable[..., Path]


def many_entries(times: int = 40) -> list[tuple[str, str, int, dict[str, Any]]]:
    """The same messages over and over, each second anew."""
    return [(t, kind, at + k * 2 * 10**9, fields) for k in range(times) for t, kind, at, fields in entries()]


def everything(path: Path) -> tuple[list[RawMessage], tuple[str, ...]]:
    """All messages, read twice with the same outcome, and what the recording says of its state."""
    with open_recording(path) as recording:
        topics = {topic.name for topic in recording.topics}
        once, faults = list(recording.messages(topics)), recording.faults
        assert [(x.topic, x.record_ns, x.data) for x in recording.messages(topics)] == [
            (x.topic, x.record_ns, x.data) for x in once
        ]
        assert recording.faults == faults
    return once, faults


def test_a_bag_that_was_never_closed_is_read_in_the_order_of_the_file(write_recording: Write) -> None:
    path = write_recording("ros1", entries())
    whole, faults = everything(path)
    assert faults == ()
    data = path.read_bytes()
    offset = data.index(b"index_pos=") + len(b"index_pos=")
    path.write_bytes(data[:offset] + bytes(8) + data[offset + 8 :])
    recovered, faults = everything(path)
    assert recovered == whole
    assert "the recorder did not close it" in faults[0]


CHUNKED = ("ros1", "ros1_lz4", "ros1_bz2", "mcap", "mcap_zstd", "mcap_lz4", "mcap_unchunked", "mcap_small_chunks")


@pytest.mark.parametrize("container", CHUNKED)
def test_a_truncated_recording_gives_what_it_still_has(container: str, write_recording: Write) -> None:
    file = file_of(write_recording(container, many_entries()))
    whole, faults = everything(file)
    assert faults == ()
    data = file.read_bytes()
    counts = []
    for share in (0.5, 0.8, 0.98):
        file.write_bytes(data[: int(len(data) * share)])
        recovered, faults = everything(file)
        assert recovered == whole[: len(recovered)]
        assert faults
        counts.append(len(recovered))
    assert counts == sorted(counts)
    assert counts[-1] > 0.6 * len(whole)


@pytest.mark.parametrize("container", ["ros1_bz2", "mcap_zstd", pytest.param("mcap_lz4", marks=pytest.mark.slow)])
def test_a_damaged_chunk_costs_its_own_messages(container: str, write_recording: Write) -> None:
    file = file_of(write_recording(container, many_entries(400)))
    whole, _ = everything(file)
    data = bytearray(file.read_bytes())
    magic = {"ros1_bz2": b"BZh", "mcap_zstd": b"\x28\xb5\x2f\xfd", "mcap_lz4": b"\x04\x22\x4d\x18"}[container]
    offset = data.index(magic) + 24
    data[offset : offset + 64] = bytes(byte ^ 0xFF for byte in data[offset : offset + 64])
    file.write_bytes(data)
    recovered, faults = everything(file)
    assert len(recovered) < len(whole)
    left = {(x.topic, x.record_ns) for x in recovered}
    lost = [n for n, x in enumerate(whole) if (x.topic, x.record_ns) not in left]
    assert lost == list(range(lost[0], lost[-1] + 1)), "what is lost is one stretch"
    assert any("skipped" in fault for fault in faults)


@pytest.mark.parametrize("container", ["ros1", "mcap_small_chunks"])
def test_what_is_lost_within_a_chunk_or_between_two_is_reported(container: str, write_recording: Write) -> None:
    file = file_of(write_recording(container, many_entries(100)))
    whole, _ = everything(file)
    data = bytearray(file.read_bytes())
    if container == "ros1":
        offset = len(data) // 3
        data[offset : offset + 3000] = b"\xff" * 3000  # lengths that no record can have
    else:
        offset = data.index(b"\x28\xb5\x2f\xfd", len(data) // 5) - 60
        data[offset : offset + 40] = b"\xfe" * 40  # neither a chunk's head nor any other record
        data[-8 - 20 :] = bytes(28)  # and no summary
    file.write_bytes(data)
    recovered, faults = everything(file)
    assert 0 < len(recovered) < len(whole)
    known = {(x.topic, x.record_ns, x.data) for x in whole}
    intact = [x for x in recovered if (x.topic, x.record_ns, x.data) in known]
    assert len(intact) >= len(recovered) - 20
    assert any("read in part" in fault or "bytes skipped" in fault for fault in faults), faults
    if container != "ros1":
        assert recovered[-1] == whole[-1], "what comes behind the damage is there"


def test_a_large_message_in_a_damaged_page_costs_itself_alone(write_recording: Write) -> None:
    image = {"height": 100, "width": 100, "step": 300, "encoding": "rgb8", "data": np.full(30_000, 7, np.uint8)}
    frames = [("/image", "sensor_msgs/msg/Image", 10**9 + k, image) for k in range(20)]
    file = file_of(write_recording("db3", frames))
    whole, _ = everything(file)
    data = bytearray(file.read_bytes())
    page = int.from_bytes(data[16:18], "big")
    middle = data.index(b"\x07" * 3000, len(data) // 2) // page * page
    data[middle : middle + 4] = b"\xff" * 4  # the link to the next page of a long message
    file.write_bytes(data)
    recovered, faults = everything(file)
    assert len(recovered) == len(whole) - 1
    assert any("read row by row" in fault for fault in faults)
    assert any("1 messages skipped" in fault for fault in faults)


def test_a_truncated_database_gives_what_it_still_has(write_recording: Write) -> None:
    file = file_of(write_recording("db3", many_entries(50)))
    whole, faults = everything(file)
    assert faults == ()
    data = file.read_bytes()
    file.write_bytes(data[: len(data) * 3 // 4])
    recovered, faults = everything(file)
    assert 0.5 * len(whole) < len(recovered) < len(whole)
    assert {(x.topic, x.record_ns, x.data) for x in recovered} <= {(x.topic, x.record_ns, x.data) for x in whole}
    assert "read row by row" in faults[0]
    file.write_bytes(data[:9000])
    with pytest.raises(DatasetsError, match=r"db3 recording|not one of its messages"):
        everything(file)


VALUES_OF_OTHER_KINDS = [("timestamp", "late"), ("timestamp", b"x"), ("timestamp", -5), ("data", None), ("data", 5)]


@pytest.mark.parametrize(("column", "value"), VALUES_OF_OTHER_KINDS)
def test_a_row_with_a_value_of_another_kind_costs_itself_alone(
    column: str, value: object, write_recording: Write
) -> None:
    file = file_of(write_recording("db3", entries()))
    whole, _ = everything(file)
    with sqlite3.connect(file) as database:
        database.executescript(
            "ALTER TABLE messages RENAME TO strict;"
            "CREATE TABLE messages (id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
            "INSERT INTO messages SELECT * FROM strict;"
        )
        update = {"timestamp": "UPDATE messages SET timestamp = ?", "data": "UPDATE messages SET data = ?"}[column]
        database.execute(f"{update} WHERE id = 3", (value,))
        database.commit()
        recovered, faults = everything(file)
        assert recovered == whole[:2] + whole[3:]
        assert faults == ("1 messages skipped: their rows hold values of other kinds",)
        database.execute(update, (value,))
    database.close()
    with pytest.raises(DatasetsError, match=r"bag\.db3: none of its 23 rows is a message"):
        read_all(file)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (
            "UPDATE topics SET name = x'00ff' WHERE id = 1",
            "20 messages skipped: the rows that name their topic are lost",
        ),
        ("UPDATE topics SET name = CAST(x'2f69ff' AS TEXT) WHERE id = 1", ""),
        ("UPDATE message_definitions SET encoded_message_definition = x'00'", "message definitions skipped"),
        ("UPDATE message_definitions SET encoded_message_definition = CAST(x'ff' AS TEXT)", ""),
    ],
)
def test_damaged_names_and_definitions_cost_no_other_topic(change: str, told: str, write_recording: Write) -> None:
    file = file_of(write_recording("db3", entries()))
    with sqlite3.connect(file) as database:
        database.execute(change)
    database.close()
    recovered, faults = everything(file)
    assert [x.topic for x in recovered][-3:] == ["/points", "/joints", "/note"]
    assert any(told in fault for fault in faults) if told else not faults
    with open_recording(file) as recording:
        (note,) = recording.messages(["/note"])
        readable = "definitions" not in change or told
        if readable:
            assert isinstance(recording.decode(note), StringSample)
        else:
            with pytest.raises(DatasetsError, match="its definition cannot be read"):
                recording.decode(note)


def test_a_damaged_message_names_topic_type_and_record_time(write_recording: Write) -> None:
    with open_recording(write_recording("mcap", entries())) as recording:
        (raw,) = recording.messages(["/note"])
        for data in (b"", b"\0", raw.data[:7], raw.data[:-3], raw.data + bytes(80), b"\7" + raw.data[1:]):
            with pytest.raises(DatasetsError, match=r"/note \(std_msgs/msg/String\) at 2000000002 ns: (the|a) message"):
                recording.decode(raw._replace(data=data))
        (imu, *_) = recording.messages(["/imu"])
        with pytest.raises(DatasetsError, match=r"/imu .* at 1000000000 ns: its header cannot be read"):
            recording.header_stamp_ns(imu._replace(data=imu.data[:9]))


def test_a_damaged_compressed_message_fails_alone(write_recording: Write) -> None:
    folder = write_recording("db3_message", entries())
    with sqlite3.connect(file_of(folder)) as database:
        database.execute("UPDATE messages SET data = substr(data, 1, length(data) - 9) WHERE topic_id = 1")
    database.close()
    with open_recording(folder) as recording:
        *damaged_imu, _, _, note = recording.messages({"/imu", "/points", "/joints", "/note"})
        assert isinstance(recording.decode(note), StringSample)
        assert len(damaged_imu) == 20
        for ask in (recording.header_stamp_ns, recording.decode):
            with pytest.raises(DatasetsError, match=r"/imu .* ns: "):
                ask(damaged_imu[0])


def damaged(data: bytes, seed: int) -> Iterator[bytes]:
    """Truncations and flipped bits, spread over the file, more of them where the small structures are: at its ends."""
    rng = np.random.default_rng(seed)
    for share in rng.random(6):
        yield data[: int(share * len(data))]
    ends = np.concatenate([rng.integers(0, 300, 6), len(data) - 1 - rng.integers(0, 300, 6)])
    for offset in np.concatenate([ends, rng.integers(0, len(data), 12)]) % len(data):
        changed = bytearray(data)
        changed[offset] ^= 1 << int(rng.integers(8))
        yield bytes(changed)


def test_damage_anywhere_never_raises_anything_else(container: str, write_recording: Write, tmp_path: Path) -> None:
    file = file_of(write_recording(container, entries()))
    data = file.read_bytes()
    target = tmp_path / f"damaged{''.join(file.suffixes)}"
    outcomes = set()
    for changed in damaged(data, seed=len(data)):
        target.write_bytes(changed)
        try:
            outcomes.add(read_all(target) == len(entries()))
        except DatasetsError as error:
            assert error.where is not None  # noqa: PT017 - the loop goes on
            assert str(target) in error.where  # noqa: PT017
            outcomes.add(False)
    assert False in outcomes
