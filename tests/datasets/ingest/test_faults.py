"""What is wrong with a recording is marked, counted or refused, and leaves nothing half-written."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hashes import hashes
from ingesting import ingested
from mcap.reader import make_reader
from mcap.writer import Writer
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.segment_step import segment_step
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.store.writer import open_store

type Drive = Callable[..., list[Any]]
type Write = Callable[..., Path]


def test_a_recording_that_lacks_streams_is_refused_or_marked(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    ingested([write_recording("mcap", drive_entries(), name="full")], out)
    poor = write_recording("mcap", drive_entries(seed=3, streams=("odometry", "camera")), name="poor")
    refused = ingested([poor], out)
    assert "lacks lidar, imu, joints, battery" in refused.quarantined[0].reason
    assert len(NavDataset(out)) == 30
    taken = ingested([poor], out, allow_missing=True)
    assert taken.rows == 30
    dataset = NavDataset(out)
    for stream in ("lidar", "imu", "joints", "battery", "action"):
        assert not dataset.column(f"valid.{stream}")[30:].any()
    assert not dataset.points(45).any()
    assert check_dataset(out).passed


def test_a_gap_stays_in_its_episode_and_is_marked(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    entries = drive_entries()
    start = entries[0][2]
    torn = [entry for entry in entries if entry[0] != "/points" or not 0.9e9 < entry[2] - start < 1.6e9]
    out = tmp_path / "out"
    ingested([write_recording("mcap", torn)], out)
    dataset = NavDataset(out)
    valid = dataset.column("valid.lidar")
    assert not valid[10:15].any()
    assert valid[:9].all()
    assert valid[17:].all()
    assert len(dataset.episodes) == 1
    assert not dataset.column("lidar.count")[~valid].any()


def test_undecodable_messages_are_counted_and_marked(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    entries = drive_entries()
    broken = [
        (topic, kind, stamp, fields | {"data": fields["data"][:40]})
        if topic.endswith("compressed") and number % 7 == 5
        else (topic, kind, stamp, fields)
        for number, (topic, kind, stamp, fields) in enumerate(entries)
    ]
    out = tmp_path / "out"
    report = ingested([write_recording("mcap", broken)], out)
    lost = int((~NavDataset(out).column("valid.camera")).sum())
    assert lost > 0
    assert report.dropped["camera: cannot be decoded"] == lost
    assert check_dataset(out).passed


def test_bad_recordings_are_quarantined_with_a_reason_and_leave_nothing(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    good = write_recording("mcap", drive_entries(), name="good")
    text = tmp_path / "notes.bag"
    text.write_text("not a bag")
    whole = write_recording("ros1", drive_entries(ros1=True), name="whole").read_bytes()
    torn = tmp_path / "torn.bag"
    torn.write_bytes(whole[:9000])  # within the definitions that precede the messages
    command = write_recording("mcap", drive_entries(streams=("command",)), name="command")
    short = write_recording("mcap", drive_entries(0.1, streams=("odometry",)), name="short")
    out = tmp_path / "out"
    report = ingested([good, text, torn, command, short], out)
    assert len(report.episodes) == 1
    reasons = {Path(entry.path).name: entry.reason for entry in report.quarantined}
    assert set(reasons) == {"notes.bag", "torn.bag", "command", "short"}
    assert "no usable stream" in reasons["command"]
    assert "less than two ticks" in reasons["short"]
    assert not (out / "navtool" / "staging").exists()
    alone = tmp_path / "alone"
    assert ingested([text], alone).episodes == []
    assert not alone.exists(), "no data set, no folder"


def test_a_torn_recording_gives_the_rows_it_still_has_and_says_so(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    whole = write_recording("ros1", drive_entries(8.0, ros1=True), name="whole").read_bytes()
    torn = tmp_path / "torn.bag"
    torn.write_bytes(whole[: len(whole) * 3 // 4])
    out = tmp_path / "out"
    report = ingested([torn], out)
    assert report.quarantined == []
    assert 45 < report.episodes[0].rows < 75
    assert any("cut off after" in text for text in noted(report.episodes[0].notes, "recording.recovered"))
    made = json.loads((NavDataset(out).layout.episode(0) / "provenance.json").read_text())
    assert any("cut off after" in fault for fault in made["recovered"])
    assert check_dataset(out).passed


def test_an_interrupted_commit_leaves_no_trace(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    out = tmp_path / "out"
    ingested([write_recording("mcap", drive_entries(seed=1), name="a")], out)
    before = hashes(out)
    layout = NavDataset(out).layout
    layout.data(1).write_bytes(b"half")
    layout.episode(1).mkdir(parents=True)
    layout.staging.mkdir()
    second = write_recording("mcap", drive_entries(seed=2), name="b")
    with open_store(out):
        assert hashes(out) == before
    assert ingested([second], out).episodes[0].episode == 1
    assert check_dataset(out).passed


def test_foreign_folders_and_other_versions_are_refused(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    path = write_recording("mcap", drive_entries())
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    (foreign / "thesis.tex").write_text("")
    with pytest.raises(DatasetsError, match="something else"):
        ingested([path], foreign)
    out = tmp_path / "out"
    ingested([path], out)
    description = out / "navtool" / "dataset.json"
    content = json.loads(description.read_text())
    description.write_text(json.dumps(content | {"schema_version": 99}))
    for work in (lambda: ingested([path], out), lambda: NavDataset(out), lambda: check_dataset(out)):
        with pytest.raises(DatasetsError, match="schema version 99"):
            work()


def test_a_recording_that_fails_late_leaves_nothing_to_the_next(
    write_recording: Write, drive_entries: Drive, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    first = write_recording("mcap", drive_entries(seed=1), name="a")
    rest = ("camera", "lidar", "odometry", "imu", "joints", "battery", "tf")
    second = write_recording("mcap", drive_entries(seed=2, streams=rest), name="b")

    def fail_once(*arguments: Any) -> None:
        segment_step(*arguments)
        monkeypatch.undo()
        raise DatasetsError("the second reading failed")

    monkeypatch.setattr("navtool.datasets.ingest.candidate.segment_step", fail_once)
    report = ingested([first, second], tmp_path / "out")
    assert [entry.reason for entry in report.quarantined] == ["the second reading failed"]
    streams = NavDataset(tmp_path / "out").layout.episode(0) / "streams"
    assert not (streams / "command.parquet").exists()
    assert not (streams / "intervention.parquet").exists()
    assert (streams / "odometry.parquet").exists()


def test_a_message_cut_within_its_header_costs_that_message_alone(
    recording_writer: Callable[..., Path], drive_entries: Drive, tmp_path: Path
) -> None:
    path = recording_writer(tmp_path, "mcap_unchunked", drive_entries(), "whole")
    out = tmp_path / "out"
    with path.open("rb") as source, (tmp_path / "cut.mcap").open("wb") as target:
        writer = Writer(target)
        writer.start(profile="ros2")
        channels: dict[int, int] = {}
        for number, (schema, channel, message) in enumerate(make_reader(source).iter_messages()):
            assert schema is not None
            if channel.id not in channels:
                kept = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, kept)
            data = message.data[:6] if channel.topic == "/points" and number % 5 == 0 else message.data
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
        writer.finish()  # type: ignore[no-untyped-call]
    report = ingested([tmp_path / "cut.mcap"], out)
    assert report.quarantined == []
    lost = int((~NavDataset(out).column("valid.lidar")).sum())
    assert 0 < lost < 15
    assert report.dropped["lidar: no stamp"] > 0
    assert check_dataset(out).passed
