"""The sync report tells what happened to time: methods, gaps, steps, delays, drift."""

from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from noted import noted

from navtool.base.files import read_json
from navtool.base.setting_error import SettingError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.clock import Clock
from navtool.datasets.streams.config import StreamSync, SyncConfig
from navtool.datasets.streams.sync import Method

Write = Callable[..., Path]
Drive = Callable[..., list[Any]]


def _report(path: Path, out: Path, config: IngestConfig | None = None) -> dict[str, Any]:
    done = ingest([path], out, RobotConfig(), config or IngestConfig())
    assert done.quarantined == []
    return read_json(NavDataset(out).layout.episode(0) / "sync.json", "")


def test_methods_rates_and_errors(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    streams = _report(write_recording("mcap", drive_entries(21.0)), tmp_path / "out")["streams"]
    assert streams["camera"]["method"] == "nearest"
    assert streams["camera"]["tolerance_s"] == 0.06
    assert "slerp" in streams["odometry"]["method"]
    assert streams["battery"]["method"] == "hold"
    assert streams["imu"]["rate_hz"] == pytest.approx(100, rel=1e-3)
    assert streams["imu"]["jitter_s"] < 1e-6
    assert streams["imu"]["header_minus_record_s"] == pytest.approx(-0.003)
    assert streams["imu"]["drift_ppm"] == pytest.approx(0.0, abs=0.1)
    assert streams["imu"]["gaps"] == []
    assert streams["intervention"]["method"] == "kept at its own rate"


def test_gaps_delays_and_drift_are_found(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    entries = []
    start = min(entry[2] for entry in drive_entries())
    for topic, kind, record_ns, fields in drive_entries(21.0):
        since = record_ns - start
        if topic == "/points" and 10e9 < since < 12e9:
            continue
        if topic == "/imu/data":
            record_ns += round(since * 200e-6)  # noqa: PLW2901 - the recorder's clock runs 200 ppm fast
        if topic == "/joint_states" and 5e9 < since < 8e9:
            record_ns = start + 8 * 10**9 + since // 1000  # noqa: PLW2901 - held back, then written at once
        entries.append((topic, kind, record_ns, fields))
    path = write_recording("mcap", sorted(entries, key=lambda entry: entry[2]))
    report = _report(path, tmp_path / "out")
    streams = report["streams"]
    (gap,) = streams["lidar"]["gaps"]
    assert gap["at_s"] == pytest.approx(9.92, abs=0.11)
    assert gap["length_s"] == pytest.approx(2.1, abs=0.11)
    assert streams["imu"]["drift_ppm"] == pytest.approx(-200, abs=10)
    assert streams["joints"]["latest_s"] == pytest.approx(3.0, abs=0.1)
    assert any("late; their stamps count" in note for note in streams["joints"]["notes"])
    assert streams["joints"]["ticks_served"] >= 208
    picture = ElementTree.parse(NavDataset(tmp_path / "out").layout.episode(0) / "sync.svg").getroot()  # noqa: S314
    texts = [element.text or "" for element in picture.iter("{http://www.w3.org/2000/svg}text")]
    assert {"camera", "lidar", "odometry", "joints"} <= set(texts)
    lost = [element for element in picture.iter("{http://www.w3.org/2000/svg}rect") if element.get("class") == "lost"]
    assert len(lost) >= 1, "the pause of the lidar is drawn"
    assert not any(reason.startswith("joints") for reason in report["dropped"])


def test_a_stepping_clock_loses_no_row(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    def stepped(entry: Any) -> Any:
        topic, kind, record_ns, fields = entry
        if "header" in fields and topic != "/imu/data" and record_ns > 1_700_000_000_000_000_000 + 4 * 10**9:
            stamp = {"sec": fields["header"]["stamp"]["sec"] - 100, "nanosec": fields["header"]["stamp"]["nanosec"]}
            fields = fields | {"header": fields["header"] | {"stamp": stamp}}
        return topic, kind, record_ns, fields

    straight = _report(write_recording("mcap", drive_entries(8.0), name="straight"), tmp_path / "as-it-was")
    path = write_recording("mcap", [stepped(entry) for entry in drive_entries(8.0)], name="stepped")
    report = _report(path, tmp_path / "out")
    assert report["ticks"] == straight["ticks"]
    for name in ("camera", "lidar", "odometry", "joints"):
        stream = report["streams"][name]
        (step,) = stream["clock_steps"]
        assert step["by_s"] == pytest.approx(-100, abs=0.01)
        assert step["at_s"] == pytest.approx(4, abs=0.2)
        assert stream["ticks_served"] == straight["streams"][name]["ticks_served"]
    assert report["streams"]["imu"]["clock_steps"] == []
    assert any(note.startswith("camera: the header clock stepped once") for note in report["notes"])


def test_the_clock_of_a_stream_can_be_set(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries())
    odometry = StreamSync(clock=Clock.record, method=Method.linear, tolerance_s=0.25)
    config = IngestConfig(sync=SyncConfig(odometry=odometry))
    streams = _report(path, tmp_path / "out", config)["streams"]
    assert streams["odometry"]["clock"] == "record"
    assert "record time, as set" in streams["odometry"]["notes"][0]
    assert streams["imu"]["clock"] == "header"
    command = StreamSync(clock=Clock.header, method=Method.hold, tolerance_s=0.5)
    refused = ingest([path], tmp_path / "no", RobotConfig(), IngestConfig(sync=SyncConfig(command=command)))
    assert "command: no message has a header stamp" in refused.quarantined[0].reason


def test_the_method_of_a_stream_can_be_set(write_recording: Write, drive_entries: Drive, tmp_path: Path) -> None:
    path = write_recording("mcap", drive_entries(4.0))
    held = StreamSync(method=Method.hold, tolerance_s=0.2)
    config = IngestConfig(sync=SyncConfig(camera=held, joints=held, odometry=held))
    streams = _report(path, tmp_path / "held", config)["streams"]
    assert [streams[name]["method"] for name in ("camera", "joints", "odometry")] == ["hold", "hold", "hold"]
    assert [streams[name]["tolerance_s"] for name in ("camera", "joints", "odometry")] == [0.2, 0.2, 0.2]
    dataset = NavDataset(tmp_path / "held")
    for name in ("camera", "joints", "state"):
        valid, error_s = dataset.column(f"valid.{name}"), dataset.column(f"sync.error_s.{name}")
        assert valid.sum() > 30
        assert (error_s[valid] <= 0).all(), "nothing of the future"
    ticks = dataset.column("stamp_ns")
    joints = dataset.stream(0, "joints")
    assert joints is not None
    newest = np.searchsorted(joints["stamp_ns"], ticks, side="right") - 1
    np.testing.assert_allclose(
        dataset.column("observation.proprioception")[:, 1], joints["position.front_right"][newest], rtol=1e-6
    )
    with pytest.raises(SettingError, match=r"lidar\.method: linear: images and clouds are not mixed"):
        SyncConfig(lidar=StreamSync(method=Method.linear, tolerance_s=0.1))


def test_motion_is_taken_out_of_clouds_with_point_times(
    write_recording: Write, drive_entries: Drive, tmp_path: Path
) -> None:
    path = write_recording("mcap", drive_entries())
    done = ingest([path], tmp_path / "timeless", RobotConfig(), IngestConfig(deskew=True))
    assert noted(done.episodes[0].notes, "lidar.not-deskewed")[0].startswith("lidar: 30 clouds")

    def timed(entry: Any) -> Any:
        topic, kind, record_ns, fields = entry
        if topic != "/points":
            return entry
        table = np.frombuffer(fields["data"].tobytes(), np.dtype([("p", "V18")]))
        wide = np.zeros(len(table), np.dtype([("p", "V18"), ("time", "<f4")]))
        wide["p"], wide["time"] = table["p"], -0.1
        field = {"name": "time", "offset": 18, "datatype": 7, "count": 1}
        size = {"point_step": 22, "row_step": 22 * len(wide), "data": np.frombuffer(wide.tobytes(), np.uint8)}
        return topic, kind, record_ns, fields | size | {"fields": [*fields["fields"], field]}

    path = write_recording("mcap", [timed(entry) for entry in drive_entries()], name="timed")
    done = ingest([path], tmp_path / "out", RobotConfig(), IngestConfig(deskew=True))
    plain = ingest([path], tmp_path / "plain", RobotConfig(), IngestConfig())
    (first_cloud,) = noted(done.episodes[0].notes, "lidar.not-deskewed")
    assert first_cloud.startswith("lidar: 1 clouds")
    assert not noted(plain.episodes[0].notes, "lidar.not-deskewed")
    moved, still = (NavDataset(tmp_path / name).points(8) for name in ("out", "plain"))
    # At 1 m/s what was seen 0.1 s before the stamp is 0.1 m nearer at the stamp.
    counts = [int(NavDataset(tmp_path / name).column("lidar.count")[8]) for name in ("out", "plain")]
    moved, still = moved[: counts[0]], still[: counts[1]]
    distance = np.abs(moved[:, None] - (still[None] - [0.1, 0.0, 0.0])).sum(axis=2).min(axis=1)
    assert np.quantile(distance, 0.95) < 0.002
