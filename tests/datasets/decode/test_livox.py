"""Livox's own clouds against a loop over the points, by the real writers of every container."""

import math
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mcap.writer
import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.livox import decode_livox
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import open_recording
from navtool.datasets.recording.message_type import message_type
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset

PACKAGES = ("livox_ros_driver", "livox_ros_driver2", "livox_interfaces")
STAMP_NS = 1_700_000_000_250_000_001
type Make = Callable[..., Any]


def cloud_fields(points: int, seed: int = 0, *, timebase: int = STAMP_NS, frame: str = "livox_frame") -> dict[str, Any]:
    rng = np.random.default_rng(seed)
    return {
        "header": {"stamp": {"sec": STAMP_NS // 10**9, "nanosec": STAMP_NS % 10**9}, "frame_id": frame},
        "timebase": timebase,
        "point_num": points,
        "lidar_id": 3,
        "rsvd": [1, 2, 3],
        "points": [
            {
                "offset_time": 5_000 * k,
                "x": float(np.float32(rng.uniform(-40, 40))),
                "y": float(np.float32(rng.uniform(-40, 40))),
                "z": float(np.float32(rng.uniform(-3, 10))),
                "reflectivity": int(rng.integers(256)),
                "tag": int(rng.integers(256)),
                "line": k % 6,
            }
            for k in range(points)
        ],
    }


def assert_is(cloud: Any, fields: dict[str, Any], shift_s: float = 0.0) -> None:
    """Point by point what was written, but for points that are not finite."""
    assert isinstance(cloud, PointCloud)
    kept = [p for p in fields["points"] if math.isfinite(p["x"]) and math.isfinite(p["y"]) and math.isfinite(p["z"])]
    assert cloud.xyz.tolist() == [[p["x"], p["y"], p["z"]] for p in kept]
    assert cloud.intensity is not None
    assert cloud.ring is not None
    assert cloud.time_s is not None
    assert cloud.intensity.tolist() == [p["reflectivity"] for p in kept]
    assert cloud.ring.tolist() == [p["line"] for p in kept]
    np.testing.assert_allclose(cloud.time_s, [p["offset_time"] * 1e-9 + shift_s for p in kept], rtol=1e-6, atol=1e-9)
    assert cloud.dropped_nonfinite == len(fields["points"]) - len(kept)
    assert (cloud.stamp_ns, cloud.frame_id) == (STAMP_NS, fields["header"]["frame_id"])


@pytest.mark.parametrize("package", PACKAGES)
@pytest.mark.parametrize("container", ["ros1", "db3", "mcap", "mcap_ros1"])
def test_through_the_real_writers(container: str, package: str, write_recording: Callable[..., Path]) -> None:
    kind = f"{package}/msg/CustomMsg"
    # Frames of any length: in CDR what follows is aligned.
    clouds = [cloud_fields(points, points, frame="livox"[:points]) for points in (0, 1, 2, 3, 4, 5, 300)]
    path = write_recording(container, [("/livox/lidar", kind, STAMP_NS + k, c) for k, c in enumerate(clouds)])
    with open_recording(path) as recording:
        for raw, fields in zip(recording.messages(["/livox/lidar"]), clouds, strict=True):
            assert recording.header_stamp_ns(raw) == STAMP_NS
            assert_is(recording.decode(raw), fields)


@pytest.mark.parametrize("package", PACKAGES)
def test_a_recording_without_definitions_is_read_all_the_same(package: str, cdr: Make) -> None:
    kind, fields = f"{package}/msg/CustomMsg", cloud_fields(20)
    for little_endian in (True, False):
        data = cdr(kind, fields, little_endian=little_endian)
        assert_is(decode_livox(message_type(kind, "cdr", None, "humble").deserialise(data)), fields)


def test_points_that_are_not_finite_are_counted_and_zeros_stay(ros_message: Make) -> None:
    fields = cloud_fields(6)
    fields["points"][1]["x"] = math.nan
    fields["points"][2]["y"] = -math.inf
    fields["points"][3] |= {"x": 0.0, "y": 0.0, "z": 0.0}
    for ros1 in (True, False):
        assert_is(decode_livox(ros_message("livox_ros_driver2/msg/CustomMsg", fields, ros1=ros1)), fields)


@pytest.mark.parametrize(
    ("timebase", "shift_s"),
    [
        (STAMP_NS, 0.0),
        (STAMP_NS - 100_000_000, -0.1),
        (STAMP_NS + 2_000_000_000, 2.0),
        (0, 0.0),
        (123_000_000_000, 0.0),
        (2**64 - 1, 0.0),
    ],
    ids=["the driver's", "stamped at the end", "stamped early", "unset", "since the sensor started", "nonsense"],
)
def test_times_count_from_the_header(timebase: int, shift_s: float, ros_message: Make) -> None:
    fields = cloud_fields(50, timebase=timebase)
    assert_is(decode_livox(ros_message("livox_ros_driver/msg/CustomMsg", fields)), fields, shift_s)


def damaged(data: bytes) -> list[bytes]:
    """The message of three points cut short at every byte, and one that says that it has more points, or fewer."""
    count = data.index((3).to_bytes(4, "little"), data.index(bytes([3, 1, 2, 3])) + 4)
    others = [data[:count] + n.to_bytes(4, "little") + data[count + 4 :] for n in (2, 4, 2**31)]
    return [*(data[:size] for size in range(len(data))), *others]


@pytest.mark.parametrize("container", ["ros1", "db3", "mcap"])
def test_a_damaged_message_is_reported_and_hinders_no_other(
    container: str, write_recording: Callable[..., Path]
) -> None:
    fields = cloud_fields(3)
    path = write_recording(container, [("/livox", "livox_ros_driver2/msg/CustomMsg", STAMP_NS, fields)])
    with open_recording(path) as recording:
        (raw,) = recording.messages(["/livox"])
        for data in damaged(raw.data):
            with pytest.raises(DatasetsError, match="/livox") as caught:
                recording.decode(raw._replace(data=data))
            assert str(path) in str(caught.value.where)
        assert_is(recording.decode(raw), fields)


def test_a_definition_of_another_layout_is_read_by_its_names(tmp_path: Path) -> None:
    """A fork whose points have their numbers in another order, and one whose points cannot be read at once."""
    head = f"std_msgs/Header header\nuint64 timebase\nlivox_ros_driver2/CustomPoint[] points\n{'=' * 80}\n"
    head += "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n" + "=" * 80 + "\n"
    head += "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" + "=" * 80 + "\n"
    point = "MSG: livox_ros_driver2/CustomPoint\n"
    names = {"x": "float32", "line": "uint8", "y": "float32", "z": "float32", "offset_time": "uint32"}
    names["reflectivity"] = "uint8"
    record = "".join(f"{kind} {name}\n" for name, kind in names.items())
    packed = b"\0\1\0\0" + struct.pack("<iIIx3xQIfB3xffIB", 1, 2, 1, 0, 1, 1.5, 2, 2.5, 3.5, 7, 9)
    path = tmp_path / "bag.mcap"
    kind = "livox_ros_driver2/msg/CustomMsg"
    with path.open("wb") as stream:
        writer: Any = mcap.writer.Writer(stream)
        writer.start(profile="ros2")
        for topic, text in (("/a", head + point + record), ("/b", f"{head}{point}uint8 first\n{record}")):
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            writer.add_message(writer.register_channel(topic, "cdr", schema), 1, packed, 1)
        writer.finish()
    with open_recording(path) as recording:
        for raw in recording.messages(["/a", "/b"]):
            if raw.topic == "/a":
                cloud = recording.decode(raw)
                assert isinstance(cloud, PointCloud)
                assert cloud.xyz.tolist() == [[1.5, 2.5, 3.5]]
            else:
                with pytest.raises(DatasetsError, match="do not all lie alike"):
                    recording.decode(raw)


def test_a_recording_with_a_livox_becomes_a_data_set(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    """The same cloud as a PointCloud2 and as Livox's own gives the same rows."""
    entries = drive_entries(1.5)
    point = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("ring", "<u2")])

    def as_livox(fields: dict[str, Any]) -> dict[str, Any]:
        points = [
            {"x": p["x"], "y": p["y"], "z": p["z"], "reflectivity": int(p["intensity"]), "line": p["ring"]}
            for p in fields["data"].view(point)
        ]
        return {"header": fields["header"], "points": points}

    livox = [
        ("/livox/lidar", "livox_ros_driver2/msg/CustomMsg", at, as_livox(fields))
        if topic == "/points"
        else (topic, kind, at, fields)
        for topic, kind, at, fields in entries
    ]
    found = []
    for name, recorded in (("cloud2", entries), ("livox", livox)):
        out = tmp_path / f"{name}-dataset"
        report = ingest([write_recording("mcap", recorded, name)], out, RobotConfig(), IngestConfig())
        assert report.quarantined == []
        found.append(NavDataset(out))
    assert found[1].provenance()[0]["topics"]["lidar"] == "/livox/lidar"
    for column in ("lidar.count", "valid.lidar", "reliability.cloud"):
        np.testing.assert_array_equal(found[0].column(column), found[1].column(column))
    for row in range(len(found[0])):
        np.testing.assert_array_equal(found[0].points(row), found[1].points(row))
