"""Damaged recordings of what other people's robots write: an episode that passes the check, or a named reason."""

import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import cv2
import DracoPy
import numpy as np
import pytest
from damage import damage_messages, damaged, in_limits, ingested
from drive_factory import START_NS, Entry, drive
from field_drives import DELAY_NS, STEP_NS, header, picture, raw
from organised_cloud import organised
from video_factory import FFMPEG, FFMPEG_TYPES, encoded

from navtool.base.errors import DatasetsError
from navtool.datasets.check import Severity, check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig

type Make = Callable[..., Any]
NUMBERS = [6, pytest.param(300, marks=pytest.mark.slow)]
IMAGE, PACKED = "sensor_msgs/msg/Image", "point_cloud_interfaces/msg/CompressedPointCloud2"


def deep(number: int, stamp_ns: int) -> dict[str, Any]:
    grey = cv2.cvtColor(picture(number), cv2.COLOR_RGB2GRAY).astype(np.uint16)
    return raw(stamp_ns, grey * 3 + 7076, "mono16")


def planes(_: int, stamp_ns: int) -> dict[str, Any]:
    planar = np.random.default_rng(0).integers(0, 255, (72, 64), dtype=np.uint8)
    return {**raw(stamp_ns, planar[:48], "nv12"), "data": planar.reshape(-1)}


def draco(_: int, stamp_ns: int) -> dict[str, Any]:
    fields = organised(stamp_ns)
    xyz = np.frombuffer(fields.pop("data"), np.float32).reshape(-1, 3)
    return {**fields, "compressed_data": np.frombuffer(DracoPy.encode(xyz), np.uint8), "format": "draco"}


def video(options: dict[str, Any], encoder: str = "libx264") -> list[Entry]:
    packets = encoded(encoder, 10, **options)
    entries = []
    for place, packet in enumerate(packets):
        more = {"encoding": encoder, "pts": packet.number, "flags": int(packet.key)}
        fields = {**header(START_NS + packet.number * STEP_NS), **more, "data": np.frombuffer(packet.data, np.uint8)}
        entries.append(("/camera/ffmpeg", FFMPEG, START_NS + place * STEP_NS + DELAY_NS, fields))
    return entries


def every(topic: str, kind: str, make: Callable[[int, int], dict[str, Any]]) -> list[Entry]:
    stamps = [START_NS + k * STEP_NS for k in range(10)]
    return [(topic, kind, stamp + DELAY_NS, make(k, stamp)) for k, stamp in enumerate(stamps)]


KINDS: dict[str, Callable[[], list[Entry]]] = {
    "video": lambda: video({"g": 4, "bf": 1, "preset": "ultrafast"}),
    "video h265": lambda: video({"preset": "ultrafast", "x265_params": "keyint=4:log-level=none"}, "libx265"),
    "16 bits": lambda: every("/camera/image_raw", IMAGE, deep),
    "planes": lambda: every("/camera/image_raw", IMAGE, planes),
    "draco": lambda: every("/points/draco", PACKED, draco),
    "clouds": lambda: every("/points", "sensor_msgs/msg/PointCloud2", lambda _, t: organised(t)),
}


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("kind", KINDS)
def test_damaged_messages_are_an_episode_or_a_reason(
    kind: str, number: int, recording_writer: Make, tmp_path: Path
) -> None:
    entries = sorted([*drive(1.0, streams=("odometry", "tf")), *KINDS[kind]()], key=lambda entry: entry[2])
    (file,) = recording_writer(tmp_path, "db3", entries, types=FFMPEG_TYPES).glob("*.db3")
    folder = tmp_path / "copies"
    folder.mkdir()
    rng = np.random.default_rng(len(kind))
    paths = [folder / f"{index}.db3" for index in range(number)]
    for path in paths:
        path.write_bytes(file.read_bytes())
        with sqlite3.connect(path) as database:
            damage_messages(database, rng)
        database.close()
    told = [ingested(path) for path in paths] if number < 20 else in_limits(ingested, [(path,) for path in paths])
    assert all(told)
    assert not any("emory" in outcome or "Error:" in outcome for outcome in told), told


@pytest.mark.parametrize("number", NUMBERS)
def test_damaged_folders_are_an_episode_or_a_reason(
    number: int, drive_entries: Make, recording_writer: Make, tmp_path: Path
) -> None:
    sound = recording_writer(tmp_path, "db3_file", drive_entries(1.0, streams=("odometry", "imu", "tf")))
    files = {path.name: path.read_bytes() for path in sound.iterdir()}
    rng = np.random.default_rng(7)
    folders = [tmp_path / f"{index}" for index in range(number)]
    for folder in folders:
        folder.mkdir()
        for name, content in files.items():
            if rng.random() < 0.9:
                (folder / name).write_bytes(damaged(content, rng) if rng.random() < 0.6 else content)
        if rng.random() < 0.3:
            (folder / str(rng.choice(["bag.db3", "bag_1.db3", "other.mcap"]))).write_bytes(files["metadata.yaml"][:50])
        (folder / "keep.txt").touch()
    told = [ingested_folder(path) for path in folders]
    assert all(told)


def ingested_folder(folder: Path) -> str:
    """What ingest says of a folder, of each recording that it finds in it; without any it is refused at once."""
    out = folder.with_name(f"{folder.name}.out")
    try:
        report = ingest([folder], out, RobotConfig(), IngestConfig(), allow_missing=True)
    except DatasetsError as error:
        return error.what
    if report.episodes:
        failed = [finding for finding in check_dataset(out).findings if finding.severity is Severity.FAIL]
        assert not failed, (folder, failed)
        shutil.rmtree(out)
    return "; ".join(
        [*(entry.reason for entry in report.quarantined), *(episode.source for episode in report.episodes)]
    )
