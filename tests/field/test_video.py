"""Videos where images are expected, through to the rows: video_packets."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from drive_factory import START_NS, drive
from field_drives import DELAY_NS, STEP_NS, Rows, header, likeness, picture, rows_of
from hashes import hashes
from ingesting import ingested
from video_factory import FFMPEG, FFMPEG_TYPES, Encoded, encoded

from navtool.datasets.ingest import segment

COMPRESSED = "sensor_msgs/msg/CompressedImage"
type Make = Callable[..., Any]
PLAIN: dict[str, Any] = {"g": 10, "bf": 0, "preset": "ultrafast", "tune": "zerolatency"}
REORDERED: dict[str, Any] = {"g": 12, "bf": 3, "preset": "medium"}


def packet_fields(packet: Encoded, kind: str, name: str) -> dict[str, Any]:
    data = np.frombuffer(packet.data, np.uint8)
    fields = header(START_NS + packet.number * STEP_NS)
    if kind == COMPRESSED:
        return {**fields, "format": name, "data": data}
    more = {"width": 320, "height": 240, "encoding": name, "pts": packet.number, "flags": int(packet.key)}
    return {**fields, **more, "data": data}


def write(
    packets: Sequence[Encoded], writer: Make, folder: Path, kind: str = FFMPEG, name: str = "h264;yuv420p;bgr8"
) -> Path:
    """A drive whose camera is a video; packets are recorded in the order of decoding, each when it can have been."""
    entries = drive(max(packet.number for packet in packets) / 10 + 0.1, streams=("odometry", "tf"))
    newest = 0
    for place, packet in enumerate(packets):
        newest = max(newest, packet.number)
        record_ns = START_NS + newest * STEP_NS + DELAY_NS + place
        entries.append(("/camera/color/image_raw/ffmpeg", kind, record_ns, packet_fields(packet, kind, name)))
    return Path(writer(folder, "mcap", sorted(entries, key=lambda entry: entry[2]), types=FFMPEG_TYPES))


def assert_each_row_shows_its_own(rows: Rows, wanted: Sequence[int]) -> None:
    """The rows with a picture show the one of their own time; the first row is that of the first one wanted."""
    valid = rows.column("valid.camera")
    first = wanted[0]
    assert [first + k for k in np.flatnonzero(valid)] == list(wanted)
    for number in wanted:
        shown = rows.pictures[number - first]
        alike = [likeness(shown, picture(number + k)) for k in (-1, 0, 1)]
        assert alike[1] > 0.97
        assert alike[1] == max(alike)


@pytest.mark.parametrize(
    ("encoder", "options", "kind", "name"),
    [
        ("libx264", PLAIN, COMPRESSED, "h264"),
        ("libx264", PLAIN, COMPRESSED, ""),
        ("libx264", PLAIN, FFMPEG, "libx264"),
        ("libx264", REORDERED, FFMPEG, "h264;yuv420p;bgr8;bgr8"),
        ("libx265", {"preset": "ultrafast", "x265_params": "keyint=10:bframes=0:log-level=none"}, FFMPEG, "hevc_nvenc"),
        ("libx265", {"x265_params": "keyint=12:bframes=3:log-level=none"}, COMPRESSED, "h265"),
        ("mpeg4", {"g": 10}, FFMPEG, "mpeg4"),
        ("libvpx-vp9", {"g": 10, "deadline": "realtime", "cpu_used": 8, "lag_in_frames": 0}, FFMPEG, "vp9"),
    ],
)
def test_every_row_has_the_picture_of_its_own_packet(
    encoder: str, options: dict[str, Any], kind: str, name: str, recording_writer: Make, tmp_path: Path
) -> None:
    packets = encoded(encoder, 26, **options)
    rows = rows_of(write(packets, recording_writer, tmp_path, kind, name), tmp_path / "dataset")
    assert_each_row_shows_its_own(rows, range(26))
    assert not rows.dropped


@pytest.mark.parametrize("options", [PLAIN, REORDERED], ids=["in order", "reordered"])
def test_rows_begin_at_the_first_key_frame_and_packets_before_it_are_counted(
    options: dict[str, Any], recording_writer: Make, tmp_path: Path
) -> None:
    packets = encoded("libx264", 40, **options)
    keys = [place for place, packet in enumerate(packets) if packet.key]
    rows = rows_of(write(packets[3:], recording_writer, tmp_path), tmp_path / "dataset")
    first = packets[keys[1]].number
    assert_each_row_shows_its_own(rows, range(first, 40))
    assert rows.dropped["camera: before the first key frame"] == keys[1] - 3


@pytest.mark.parametrize("options", [PLAIN, REORDERED], ids=["in order", "reordered"])
def test_behind_lost_packets_there_is_no_picture_until_the_next_key_frame(
    options: dict[str, Any], recording_writer: Make, tmp_path: Path
) -> None:
    packets = encoded("libx264", 40, **options)
    keys = [place for place, packet in enumerate(packets) if packet.key]
    lost = keys[1] + 1
    rows = rows_of(write([*packets[:lost], *packets[lost + 1 :]], recording_writer, tmp_path), tmp_path / "dataset")
    missing = {packet.number for packet in packets[lost : keys[2]]}
    valid = set(np.flatnonzero(rows.column("valid.camera")).tolist())
    assert valid.isdisjoint(missing) or options is REORDERED
    for number in valid:
        assert likeness(rows.pictures[number], picture(number)) > 0.97
    assert valid >= set(range(40)) - missing
    assert rows.dropped.get("camera: cannot be decoded", 0) >= 1


def test_segments_begin_at_an_earlier_key_frame(
    recording_writer: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = write(encoded("libx264", 60, **REORDERED), recording_writer, tmp_path)
    whole = rows_of(recording, tmp_path / "whole")
    monkeypatch.setattr(segment, "TICKS_PER_SEGMENT", 7)
    parts = rows_of(recording, tmp_path / "parts")
    assert_each_row_shows_its_own(parts, range(60))
    assert parts.dropped == whole.dropped == {}


def test_any_number_of_workers_gives_the_same_bytes(recording_writer: Make, tmp_path: Path) -> None:
    recording = write(encoded("libx264", 30, **PLAIN), recording_writer, tmp_path)
    for workers in (1, 2):
        rows_of(recording, tmp_path / f"{workers}", workers=workers)
    assert hashes(tmp_path / "1") == hashes(tmp_path / "2")


def without_later_parameters(packets: Sequence[Encoded]) -> list[Encoded]:
    return [
        packet
        if place == 0 or not packet.key
        else packet._replace(data=b"\0\0\0\1" + packet.data[packet.data.find(b"\0\0\1\x65") + 3 :])
        for place, packet in enumerate(packets)
    ]


def test_packets_are_missed_behind_key_frames_without_parameter_sets_too(
    recording_writer: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packets = without_later_parameters(encoded("libx264", 40, **PLAIN))
    lost = next(place for place, packet in enumerate(packets) if packet.number == 33)
    monkeypatch.setattr(segment, "TICKS_PER_SEGMENT", 7)
    recording = write([*packets[:lost], *packets[lost + 1 :]], recording_writer, tmp_path)
    rows = rows_of(recording, tmp_path / "dataset")
    assert_each_row_shows_its_own(rows, range(33))
    assert rows.dropped["camera: cannot be decoded"] == 6


def test_parameter_sets_that_came_once_hold_for_later_key_frames(
    recording_writer: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    packets = encoded("libx264", 40, **PLAIN)
    bare = without_later_parameters(packets)
    assert sum(len(x.data) for x in bare) < sum(len(x.data) for x in packets)
    monkeypatch.setattr(segment, "TICKS_PER_SEGMENT", 15)
    rows = rows_of(write(bare, recording_writer, tmp_path), tmp_path / "dataset")
    assert_each_row_shows_its_own(rows, range(40))


@pytest.mark.parametrize(
    ("keep", "name", "told"),
    [
        (lambda packets: packets[3:9], "h264", "video stream of h264 without a key frame among its 6 packets"),
        (lambda packets: packets, "prores_ks", "a video stream of 'prores_ks', which is not decoded"),
    ],
    ids=["no key frame", "another codec"],
)
def test_a_video_that_cannot_be_decoded_is_named_as_one(
    keep: Callable[[list[Encoded]], list[Encoded]], name: str, told: str, recording_writer: Make, tmp_path: Path
) -> None:
    packets = keep(encoded("libx264", 20, **PLAIN))
    report = ingested([write(packets, recording_writer, tmp_path, name=name)], tmp_path / "dataset")
    said = [entry.reason for entry in report.quarantined] + [note.text for e in report.episodes for note in e.notes]
    assert any(told in text for text in said), said
