"""Planar scans as clouds against a loop over the beams, in every container, and all the way into a data set."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from noted import noted

from navtool.base.errors import DatasetsError
from navtool.datasets.check.run import check_dataset
from navtool.datasets.decode.laser_scan import decode_laser_scan
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset

SCAN = "sensor_msgs/msg/LaserScan"
STAMP_NS = 1_700_000_000_250_000_000
CONTAINERS = ("ros1", "db3", "mcap")
type Make = Callable[..., Any]


def scan_fields(ranges: list[float], intensities: list[float], **change: float) -> dict[str, Any]:
    return {
        "header": {"stamp": {"sec": STAMP_NS // 10**9, "nanosec": STAMP_NS % 10**9}, "frame_id": "laser"},
        "angle_min": -2.0,
        "angle_max": 2.0,
        "angle_increment": 0.03125,
        "time_increment": 0.0009765625,
        "scan_time": 0.1,
        "range_min": 0.25,
        "range_max": 30.0,
        "ranges": ranges,
        "intensities": intensities,
        **change,
    }


def beam_by_beam(fields: dict[str, Any]) -> list[tuple[float, ...]]:
    """x, y, z, intensity (NaN for none), ring and time of each return."""
    found: list[tuple[float, ...]] = []
    several = len(fields["intensities"]) == len(fields["ranges"])
    for k, distance in enumerate(np.array(fields["ranges"], np.float32).tolist()):
        if math.isnan(distance) or math.isinf(distance):
            continue
        if distance < fields["range_min"] or distance > fields["range_max"]:
            continue
        angle = fields["angle_min"] + k * fields["angle_increment"]
        intensity = float(np.float32(fields["intensities"][k])) if several else math.nan
        x, y = distance * math.cos(angle), distance * math.sin(angle)
        found.append((x, y, 0.0, intensity, 0.0, k * fields["time_increment"]))
    return found


def assert_is(cloud: PointCloud, expected: list[tuple[float, ...]]) -> None:
    columns = np.array(expected, np.float64).reshape(-1, 6)
    np.testing.assert_allclose(cloud.xyz, columns[:, :3], rtol=1e-6, atol=1e-6)
    if cloud.intensity is None:
        assert np.isnan(columns[:, 3]).all()
    else:
        np.testing.assert_array_equal(cloud.intensity, columns[:, 3])
    assert cloud.ring is not None
    assert cloud.time_s is not None
    np.testing.assert_array_equal(cloud.ring, columns[:, 4])
    np.testing.assert_allclose(cloud.time_s, columns[:, 5], rtol=1e-6)
    assert (cloud.stamp_ns, cloud.frame_id, cloud.dropped_nonfinite) == (STAMP_NS, "laser", 0)


any_range = st.one_of(
    st.floats(0, 50, width=32), st.sampled_from([math.nan, math.inf, -math.inf, 0.25, 30.0, 0.0, -1.0])
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=150, deadline=None)
@given(ranges=st.lists(any_range, max_size=40), with_intensity=st.booleans(), ros1=st.booleans())
def test_every_return_is_where_its_beam_points(
    ranges: list[float], with_intensity: bool, ros1: bool, ros_message: Make
) -> None:
    fields = scan_fields(ranges, [float(k) for k in range(len(ranges))] if with_intensity else [])
    assert_is(decode_laser_scan(ros_message(SCAN, fields, ros1=ros1)), beam_by_beam(fields))


def test_the_limits_belong_to_the_scanner_and_intensities_count_only_one_a_beam(ros_message: Make) -> None:
    fields = scan_fields([0.25, 0.2499, 30.0, 30.01, math.nan, math.inf, -math.inf, 5.0], [1.0])
    cloud = decode_laser_scan(ros_message(SCAN, fields))
    np.testing.assert_allclose(np.linalg.norm(cloud.xyz, axis=1), [0.25, 30.0, 5.0], rtol=1e-6)
    assert cloud.intensity is None
    endless = scan_fields([0.1, 1e8, 1e30, math.inf], [], range_min=-math.inf, range_max=math.inf)
    far = decode_laser_scan(ros_message(SCAN, endless))
    assert (len(far.xyz), far.dropped_nonfinite) == (2, 1), "a return from beyond all measure is counted as lost"


@pytest.mark.parametrize("name", ["angle_min", "angle_increment", "range_min", "range_max"])
def test_a_scan_without_angles_or_limits_is_refused(name: str, ros_message: Make) -> None:
    with pytest.raises(DatasetsError, match="these are no numbers"):
        decode_laser_scan(ros_message(SCAN, scan_fields([1.0], [], **{name: math.nan})))
    timeless = decode_laser_scan(ros_message(SCAN, scan_fields([1.0], [], time_increment=math.nan)))
    assert timeless.time_s is None


@pytest.mark.parametrize("container", CONTAINERS)
def test_through_the_real_writers(container: str, write_recording: Callable[..., Path]) -> None:
    rng = np.random.default_rng(3)
    scans = [
        scan_fields(np.where(rng.random(897) < 0.2, np.inf, rng.uniform(0, 40, 897)).tolist(), rng.random(897).tolist())
        for _ in range(3)
    ]
    path = write_recording(container, [("/scan", SCAN, STAMP_NS + k, fields) for k, fields in enumerate(scans)])
    with open_recording(path) as recording:
        for raw, fields in zip(recording.messages(["/scan"]), scans, strict=True):
            cloud = recording.decode(raw)
            assert isinstance(cloud, PointCloud)
            assert 0 < len(cloud.xyz) < 897
            assert_is(cloud, beam_by_beam(fields))


def room(stamp: dict[str, Any]) -> dict[str, Any]:
    """A planar scan of a room of 8 m by 6 m; every tenth beam goes through a window."""
    angle = -np.pi + np.arange(720) * np.radians(0.5)
    wall = np.minimum(4.0 / np.maximum(np.abs(np.cos(angle)), 1e-9), 3.0 / np.maximum(np.abs(np.sin(angle)), 1e-9))
    wall[::10] = np.inf
    limits = {"angle_min": -np.pi, "angle_increment": np.radians(0.5), "range_min": 0.1, "range_max": 20.0}
    return {**stamp, **limits, "time_increment": 0.1 / 720, "ranges": wall, "intensities": np.arange(720.0)}


@pytest.mark.parametrize("deskew", [False, True])
def test_a_recording_with_a_planar_scanner_becomes_a_sound_data_set(
    deskew: bool, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    entries = [
        ("/scan", SCAN, record_ns, room({"header": fields["header"]}))
        if topic == "/points"
        else (topic, kind, record_ns, fields)
        for topic, kind, record_ns, fields in drive_entries(2.0, crash=False)
    ]
    out = tmp_path / "out"
    report = ingest([write_recording("mcap", entries)], out, RobotConfig(), IngestConfig(deskew=deskew))
    assert report.quarantined == []
    (episode,) = report.episodes
    assert episode.topics["lidar"] == "/scan"
    assert noted(episode.notes, "topics.planar-scan")
    assert not any("lidar points" in reason for reason in report.dropped), "a beam without a return is no lost point"
    dataset = NavDataset(out)
    assert dataset.column("valid.lidar")[2:].all()
    kept = int(dataset.column("lidar.count")[5])
    points = dataset.points(5)[:kept]
    assert 100 < kept < 360, "the front half, one point a voxel"
    np.testing.assert_allclose(points[:, 2], 0.6, atol=1e-3)  # the scanner's height
    if not deskew:
        near_wall = np.minimum(np.abs(points[:, 0] - 4.0), np.abs(np.abs(points[:, 1]) - 3.0))
        assert near_wall.max() < 2e-3
    assert dataset.column("reliability.cloud")[5] > 0.5
    (cloud, *_) = dataset.clouds(0)
    assert len(cloud.xyz) == 648
    assert cloud.ring is not None
    assert not cloud.ring.any()
    assert check_dataset(out).passed
