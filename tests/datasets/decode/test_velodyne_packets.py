"""Raw VLP-16 packets against the points that another decoder gave of a real capture, and against the manual."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.decode.velodyne_packets import decode_velodyne_scan
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset

SCAN = "velodyne_msgs/msg/VelodyneScan"
HEIGHTS_MM = (11.2, 9.7, 8.1, 6.6, 5.1, 3.7, 2.2, 0.7, -0.7, -2.2, -3.7, -5.1, -6.6, -8.1, -9.7, -11.2)
"""By ring, as the manual has them; the other decoder leaves them out."""
TRUTH = np.dtype(
    [(axis, "<f4") for axis in "xyz"]
    + [("intensity", "u1"), ("return_type", "u1"), ("channel", "<u2")]
    + [(name, "<f4") for name in ("azimuth", "elevation", "distance")]
    + [("time_ns", "<u4")]
)


type Bytes = np.ndarray[Any, np.dtype[np.uint8]]


def _packet(azimuth: int, distance: int, *, product: int = 0x22, mode: int = 0x37) -> Bytes:
    data = bytearray()
    for block in range(12):
        data += b"\xff\xee" + ((azimuth + 40 * block) % 36000).to_bytes(2, "little")
        data += b"".join(distance.to_bytes(2, "little") + bytes([beam]) for beam in range(32))
    return np.frombuffer(bytes(data + bytes(4) + bytes([mode, product])), np.uint8)


def _scan(ros_message: Callable[..., Any], packets: list[Any]) -> PointCloud:
    message = ros_message("sensor_msgs/msg/Imu", {"header": {"stamp": {"sec": 5}, "frame_id": "velodyne"}})

    class Scan:
        header = message.header

    scan: Any = Scan()
    size = packets[0].size if packets else 1206
    kind = np.dtype([("stamp", [("sec", "<i4"), ("nanosec", "<u4")]), ("data", "u1", (size,))])
    scan.packets = np.array([((4, 900_000_000), data) for data in packets], kind)
    return decode_velodyne_scan(scan)


def test_every_beam_goes_where_the_manual_says(ros_message: Callable[..., Any]) -> None:
    cloud = _scan(ros_message, [_packet(0, 5000)])
    assert len(cloud.xyz) == 384
    assert cloud.ring is not None
    assert cloud.time_s is not None
    assert cloud.intensity is not None
    np.testing.assert_array_equal(cloud.intensity[:32], np.arange(32))
    heights = np.array(HEIGHTS_MM)[cloud.ring] * 1e-3
    centred = cloud.xyz - np.array([0.0, 0.0, 1.0]) * heights[:, None]
    np.testing.assert_allclose(np.linalg.norm(centred, axis=1), 10.0, atol=1e-5)
    elevation = np.degrees(np.arcsin(centred[:, 2] / 10.0))
    np.testing.assert_allclose(elevation, -15 + 2 * cloud.ring.astype(float), atol=1e-4)
    azimuth = np.degrees(np.arctan2(-centred[:, 1], centred[:, 0]))
    assert azimuth[0] == pytest.approx(0.0, abs=1e-4)
    assert azimuth[32] == pytest.approx(0.4, abs=1e-4)
    assert azimuth[16] == pytest.approx(0.2, abs=1e-4)
    assert (np.diff(azimuth) > 0).all(), "the head turns clockwise, seen from above"
    assert cloud.time_s[0] == pytest.approx(-0.1)
    assert cloud.time_s[-1] == pytest.approx(-0.1 + 23 * 55.296e-6 + 15 * 2.304e-6, abs=1e-7)


def test_two_returns_a_beam_are_one_point_where_they_are_equal(ros_message: Callable[..., Any]) -> None:
    packet = _packet(0, 5000, mode=0x39).copy()
    blocks = packet[:1200].reshape(12, 100)
    blocks[:, 2:4] = np.repeat((np.arange(6) * 40).astype("<u2").view(np.uint8).reshape(6, 2), 2, axis=0)
    assert len(_scan(ros_message, [packet]).xyz) == 192
    blocks[1, 4:6] = np.array([6000], "<u2").view(np.uint8)
    assert len(_scan(ros_message, [packet]).xyz) == 193


def test_other_sensors_and_torn_packets_are_refused(ros_message: Callable[..., Any]) -> None:
    with pytest.raises(DatasetsError, match="HDL-32E"):
        _scan(ros_message, [_packet(0, 5000, product=0x21)])
    with pytest.raises(DatasetsError, match="packets of 900 bytes"):
        _scan(ros_message, [_packet(0, 5000)[:900]])
    with pytest.raises(DatasetsError, match="without packets"):
        _scan(ros_message, [])
    assert len(_scan(ros_message, [_packet(0, 0)]).xyz) == 0, "no return, no point"


def test_a_real_capture_gives_the_points_that_another_decoder_gave(recordings: Path, tmp_path: Path) -> None:
    folder = recordings / "lidar" / "nebula_vlp16"
    with open_recording(next(folder.glob("*/*.db3"))) as recording:
        clouds = [recording.decode(raw) for raw in recording.messages(["/velodyne_packets"])]
    assert all(isinstance(cloud, PointCloud) for cloud in clouds)
    body = next(folder.glob("*.pcd")).read_bytes().split(b"DATA binary\n", 1)[1]
    truth = np.frombuffer(body, TRUTH, 14_831)
    points: list[Any] = [cloud for cloud in clouds if isinstance(cloud, PointCloud)]
    ring = np.concatenate([cloud.ring for cloud in points])
    xyz = np.concatenate([cloud.xyz for cloud in points]).astype(float)
    xyz[:, 2] -= np.array(HEIGHTS_MM)[ring] * 1e-3
    wanted = np.stack([truth[axis].astype(np.float64) for axis in "xyz"], axis=1)
    tree: Any = cKDTree(xyz)
    distance, nearest = tree.query(wanted)
    assert np.median(distance) < 0.0005
    assert np.quantile(distance, 0.97) < 0.01
    assert distance.max() < 0.06, "a hundredth of a degree at 100 m is 2 cm"
    near = distance < 0.01
    np.testing.assert_array_equal(ring[nearest][near], truth["channel"][near])
    intensity = np.concatenate([cloud.intensity for cloud in points])
    assert (intensity[nearest] == truth["intensity"])[near].mean() > 0.94
    report = ingest([next(folder.glob("*/"))], tmp_path / "out", RobotConfig(), IngestConfig())
    assert report.quarantined == []
    assert NavDataset(tmp_path / "out").column("lidar.count").min() > 1000
