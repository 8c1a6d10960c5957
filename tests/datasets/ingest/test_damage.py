"""Content that no robot measured: it costs itself, is told, and what is written passes the check."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from noted import noted

from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.ingest.report import EpisodeSummary
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset

Entries = list[tuple[str, str, int, dict[str, Any]]]
Survive = Callable[[Entries], tuple[EpisodeSummary, NavDataset]]
BEYOND = "odometry: 1 values are infinite or beyond 1e15: not measured"
HOUR_NS = 3_600 * 10**9


@pytest.fixture
def survive(write_recording: Callable[..., Path], tmp_path: Path) -> Survive:
    """``survive(entries)``: the episode's summary and the data set, which passes the check."""

    def run(entries: Entries) -> tuple[EpisodeSummary, NavDataset]:
        out = tmp_path / "out"
        report = ingest([write_recording("mcap", entries)], out, RobotConfig(), IngestConfig())
        assert not report.quarantined, report.quarantined
        checked = check_dataset(out)
        assert checked.passed, checked.findings
        return report.episodes[0], NavDataset(out)

    return run


def changed(entries: Entries, topic: str, change: Callable[[dict[str, Any]], dict[str, Any]], *only: int) -> Entries:
    """The entries with the fields of a topic's messages changed, of all or of the numbered ones."""
    number, made = -1, []
    for name, kind, at, fields in entries:
        number += name == topic
        hit = name == topic and (not only or number in only)
        made.append((name, kind, at, fields | change(fields) if hit else fields))
    return made


@pytest.mark.parametrize("number", [np.inf, -1e300, 3e38])
def test_a_speed_beyond_all_measure_costs_the_rows_around_it(
    number: float, drive_entries: Callable[..., Entries], survive: Survive
) -> None:
    def fast(_fields: dict[str, Any]) -> dict[str, Any]:
        return {"twist": {"twist": {"linear": {"x": number}}}}

    told, dataset = survive(changed(drive_entries(), "/odom", fast, 50))
    assert noted(told.notes, "stream.beyond-measure") == [BEYOND]
    lost = np.flatnonzero(~dataset.column("valid.state")).tolist()
    assert lost == [10]
    assert not dataset.column("observation.state")[lost].any()


def test_poses_beyond_all_measure_make_no_speeds(drive_entries: Callable[..., Entries], survive: Survive) -> None:
    def lost(fields: dict[str, Any]) -> dict[str, Any]:
        return {"pose": {"pose": fields["pose"]["pose"] | {"orientation": {"w": 1e200}}}}

    entries = changed(drive_entries(crash=False), "/odom", lambda _: {"twist": {}})
    every_fifth = [entry for n, entry in enumerate(e for e in entries if e[0] == "/odom") if n % 5 == 0]
    sparse = sorted([*(e for e in entries if e[0] != "/odom"), *every_fifth], key=lambda entry: entry[2])
    told, dataset = survive(changed(sparse, "/odom", lost, 7))
    assert noted(told.notes, "stream.beyond-measure") == [BEYOND]
    valid = dataset.column("valid.state")
    assert np.flatnonzero(~valid).tolist() == [7]
    np.testing.assert_allclose(dataset.column("observation.state")[valid, 0], 1.0, atol=1e-6)


def test_an_effort_that_is_never_measured_is_zero(drive_entries: Callable[..., Entries], survive: Survive) -> None:
    unknown = np.array([1.0, float(np.finfo(np.float64).max)])
    told, dataset = survive(changed(drive_entries(), "/joint_states", lambda _: {"effort": unknown}))
    assert noted(told.notes, "joints.never-measured")
    assert dataset.column("valid.joints")[:25].all()
    assert not dataset.column("observation.proprioception")[:, 5].any()
    native = dataset.stream(0, "joints")
    assert native is not None
    assert np.isnan(native["effort.front_right"]).all()


@pytest.mark.parametrize("topic", ["/imu/data", "/battery_state", "/cmd_vel"])
def test_any_small_stream_may_be_infinite(topic: str, drive_entries: Callable[..., Entries], survive: Survive) -> None:
    endless = {"x": np.inf, "y": np.inf, "z": -np.inf}
    every: dict[str, dict[str, Any]] = {
        "/imu/data": {"linear_acceleration": endless, "angular_velocity": endless},
        "/battery_state": {"current": np.inf},
        "/cmd_vel": {"linear": endless},
    }
    told, dataset = survive(changed(drive_entries(), topic, lambda _: every[topic]))
    stream = {"/imu/data": "imu", "/battery_state": "battery", "/cmd_vel": "action"}[topic]
    assert not dataset.column(f"valid.{stream}").any()
    assert noted(told.notes, "stream.beyond-measure")


def test_geometry_beyond_all_measure_stays_unknown(drive_entries: Callable[..., Entries], survive: Survive) -> None:
    def lost(fields: dict[str, Any]) -> dict[str, Any]:
        first, *others = fields["transforms"]
        far = first["transform"] | {"translation": {"x": np.nan, "y": 0.0, "z": 0.0}}
        return {"transforms": [first | {"transform": far}, *others]}

    entries = changed(drive_entries(), "/tf_static", lost)
    told, dataset = survive(changed(entries, "/camera/camera_info", lambda _: {"p": np.full(12, np.nan)}))
    refused = [text.partition(":")[0] for text in noted(told.notes, "topic.refused")]
    assert sorted(refused) == ["/camera/camera_info", "/tf_static"]
    calibration = dataset.calibration(0)
    assert (calibration.camera, calibration.base_camera) == (None, None)


def test_points_beyond_all_measure_are_counted(drive_entries: Callable[..., Entries], survive: Survive) -> None:
    def far(fields: dict[str, Any]) -> dict[str, Any]:
        data = fields["data"].copy()
        data[: 18 * 7].reshape(7, 18)[:, :12] = np.frombuffer(np.full(3, 3e38, "<f4").tobytes(), np.uint8)
        return {"data": data}

    told, dataset = survive(changed(drive_entries(), "/points", far, 3, 4))
    assert told.dropped["lidar points: not finite"] == 14
    assert [len(cloud.xyz) for cloud in dataset.clouds(0)][2:6] == [600, 593, 593, 600]


def test_a_wrong_stamp_or_a_silent_hour_is_refused_and_record_time_is_the_cure(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Entries], tmp_path: Path
) -> None:
    def wrong(fields: dict[str, Any]) -> dict[str, Any]:
        stamp = fields["header"]["stamp"]
        return {"header": fields["header"] | {"stamp": stamp | {"sec": stamp["sec"] + (1 << 20)}}}

    def burst(topic: str, at: int) -> int:
        return at - at % 10**9 + 999_999_999 if topic.startswith("/camera") else at

    # Frames that are recorded a second at a time show no pace by which a step of their clock could be told.
    entries = changed(drive_entries(6.0), "/camera/image_raw/compressed", wrong, 40)
    bursts = sorted(((t, k, burst(t, at), f) for t, k, at, f in entries), key=lambda entry: entry[2])
    path = write_recording("mcap", bursts)
    report = ingest([path], tmp_path / "out", RobotConfig(), IngestConfig())
    (found,) = report.quarantined
    assert "camera: silence of 10485" in found.reason
    assert "sync.camera.clock=record" in found.reason
    assert not (tmp_path / "out").exists()
    later = [(t, k, at + 2 * HOUR_NS * (at > entries[0][2] + 3 * 10**9), f) for t, k, at, f in drive_entries(6.0)]
    unstamped = [(t, k, at, f | ({"header": {}} if "header" in f else {})) for t, k, at, f in later]
    report = ingest([write_recording("mcap", unstamped, "two")], tmp_path / "two-runs", RobotConfig(), IngestConfig())
    assert "silence of 7200" in report.quarantined[0].reason


def test_a_stream_of_the_grid_may_pause_for_hours_while_another_goes_on(
    drive_entries: Callable[..., Entries], survive: Survive, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("navtool.datasets.ingest.grid.MOST_PAUSE_S", 5.0)
    entries = drive_entries(2.0, streams=("camera", "odometry"))
    first_ns = entries[0][2]
    stretched = [(t, k, at + (at - first_ns > 10**9) * 12 * 10**9, f | {"header": {}}) for t, k, at, f in entries]
    _, kind, _, fields = next(entry for entry in entries if entry[0] == "/odom")
    between = [("/odom", kind, first_ns + second * 10**9, fields | {"header": {}}) for second in (4, 8, 12)]
    told, _ = survive(sorted((*stretched, *between), key=lambda entry: entry[2]))
    frames_ns = [at for topic, _, at, _ in stretched if topic.endswith("compressed")]
    assert told.rows == (frames_ns[-1] - frames_ns[0]) // 10**8 + 1


def test_a_damaged_definition_of_a_fast_stream_costs_that_stream(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Entries], tmp_path: Path
) -> None:
    path = write_recording("mcap", drive_entries())
    file = next(x for x in path.iterdir() if x.suffix == ".mcap")
    data = file.read_bytes()
    for name in (b"geometry_msgs/TwistWithCovariance twist", b"geometry_msgs/msg/TwistWithCovariance twist"):
        data = data.replace(name, name.replace(b"Covariance", b"Cavariance"))
    file.write_bytes(data)
    out = tmp_path / "out"
    report = ingest([path], out, RobotConfig(), IngestConfig())
    assert check_dataset(out).passed
    assert noted(report.episodes[0].notes, "stream.undecodable")
    made = json.loads((NavDataset(out).layout.episode(0) / "provenance.json").read_text())
    assert made["topics"]["odometry"] == "/odom"
    assert not NavDataset(out).column("valid.state").any()
