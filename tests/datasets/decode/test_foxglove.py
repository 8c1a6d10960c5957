"""Foxglove's schemas in JSON and protobuf, written by the real writers, become the same data set as ROS messages do."""

import base64
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from google.protobuf import descriptor_pb2, descriptor_pool, json_format, message_factory, timestamp_pb2
from mcap.writer import Writer

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig, TopicCandidates
from navtool.datasets.store.reader import NavDataset

TYPES: dict[str, dict[str, str]] = {
    "Vector3": {"x": "double", "y": "double", "z": "double"},
    "Quaternion": {"x": "double", "y": "double", "z": "double", "w": "double"},
    "Pose": {"position": "Vector3", "orientation": "Quaternion"},
    "CompressedImage": {"timestamp": "time", "frame_id": "string", "data": "bytes", "format": "string"},
    "PackedElementField": {"name": "string", "offset": "uint32", "type": "uint32"},
    "PointCloud": {
        "timestamp": "time",
        "frame_id": "string",
        "pose": "Pose",
        "point_stride": "uint32",
        "fields": "PackedElementField*",
        "data": "bytes",
    },
    "PoseInFrame": {"timestamp": "time", "frame_id": "string", "pose": "Pose"},
    "FrameTransform": {
        "timestamp": "time",
        "parent_frame_id": "string",
        "child_frame_id": "string",
        "translation": "Vector3",
        "rotation": "Quaternion",
    },
    "FrameTransforms": {"transforms": "FrameTransform*"},
    "CameraCalibration": {
        "timestamp": "time",
        "frame_id": "string",
        "width": "uint32",
        "height": "uint32",
        "distortion_model": "string",
        "D": "double*",
        "K": "double*",
        "R": "double*",
        "P": "double*",
    },
}
_KINDS = {"double": 1, "string": 9, "bytes": 12, "uint32": 13}
NUMERIC = {7: 7, 4: 3, 2: 1}
"""sensor_msgs' numeric types by Foxglove's."""


def _descriptors() -> Any:
    """The schemas as protobuf describes them, in a set whose files are not in the order of their imports."""
    file = descriptor_pb2.FileDescriptorProto(name="foxglove.proto", package="foxglove", syntax="proto3")
    file.dependency.append("google/protobuf/timestamp.proto")
    for name, fields in TYPES.items():
        message = file.message_type.add(name=name)
        for number, (field, kind) in enumerate(fields.items(), start=1):
            entry = message.field.add(name=field, number=number, label=3 if kind.endswith("*") else 1)
            plain = kind.rstrip("*")
            entry.type = _KINDS.get(plain, 11)
            if plain not in _KINDS:
                entry.type_name = ".google.protobuf.Timestamp" if plain == "time" else f".foxglove.{plain}"
    time = descriptor_pb2.FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(time)
    return descriptor_pb2.FileDescriptorSet(file=[file, time])


def _as_foxglove(entry: Any) -> tuple[str, str, int, dict[str, Any]] | None:
    """The same content in Foxglove's schema; None where it has none for it."""
    topic, kind, record_ns, fields = entry
    head = fields.get("header", {})
    common = {"timestamp": head.get("stamp"), "frame_id": head.get("frame_id", "")}
    match kind.rpartition("/")[2]:
        case "CompressedImage":
            own: dict[str, Any] = {"data": bytes(fields["data"]), "format": "jpeg"}
        case "PointCloud2":
            points = [
                {"name": x["name"], "offset": x["offset"], "type": NUMERIC[x["datatype"]]} for x in fields["fields"]
            ]
            pose = {"position": {"x": 0.0, "y": 0.0, "z": 0.0}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
            own = {"pose": pose, "point_stride": fields["point_step"], "fields": points, "data": bytes(fields["data"])}
            kind = "PointCloud"
        case "Odometry":
            kind, own = "PoseInFrame", {"pose": fields["pose"]["pose"]}
        case "CameraInfo":
            kind = "CameraCalibration"
            own = {key: fields[key] for key in ("width", "height", "distortion_model")}
            own |= {key.upper(): [float(value) for value in fields[key]] for key in "dkrp"}
        case "TFMessage":
            transforms = [
                {
                    "timestamp": x["header"]["stamp"],
                    "parent_frame_id": x["header"]["frame_id"],
                    "child_frame_id": x["child_frame_id"],
                    "translation": x["transform"]["translation"],
                    "rotation": x["transform"]["rotation"],
                }
                for x in fields["transforms"]
            ]
            return topic, "FrameTransforms", record_ns, {"transforms": transforms}
        case _:
            return None
    return topic, kind.rpartition("/")[2], record_ns, common | own


def _json(value: Any) -> Any:
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    if isinstance(value, dict):
        renamed = {"nanosec": "nsec"}
        return {renamed.get(key, key): _json(entry) for key, entry in value.items()}
    return [_json(entry) for entry in value] if isinstance(value, list) else value


def _proto_json(value: Any) -> Any:
    """As protobuf's own JSON has it: a time is a text, and bytes are base64."""
    if isinstance(value, dict) and set(value) == {"sec", "nanosec"}:
        stamp = timestamp_pb2.Timestamp(seconds=value["sec"], nanos=value["nanosec"])
        return stamp.ToJsonString()
    if isinstance(value, dict):
        return {key: _proto_json(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_proto_json(entry) for entry in value]
    return _json(value)


def _write(path: Path, encoding: str, entries: list[Any]) -> Path:
    described = _descriptors()
    pool = descriptor_pool.DescriptorPool()
    for file in reversed(described.file):
        pool.Add(file)
    with path.open("wb") as stream:
        writer: Any = Writer(stream)
        writer.start()
        channels: dict[str, int] = {}
        for topic, kind, record_ns, fields in entries:
            name = f"foxglove.{kind}"
            if topic not in channels:
                schema = described.SerializeToString() if encoding == "protobuf" else b"{}"
                form = "protobuf" if encoding == "protobuf" else "jsonschema"
                channels[topic] = writer.register_channel(topic, encoding, writer.register_schema(name, form, schema))
            if encoding == "json":
                data = json.dumps(_json(fields)).encode()
            else:
                message = message_factory.GetMessageClass(pool.FindMessageTypeByName(name))()
                data = json_format.ParseDict(_proto_json(fields), message).SerializeToString()
            writer.add_message(channels[topic], record_ns, data, record_ns)
        writer.finish()
    return path


@pytest.mark.parametrize("encoding", ["json", "protobuf"])
def test_a_drive_in_foxglove_schemas_becomes_the_same_rows(
    encoding: str, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    entries = drive_entries(2.0, crash=False, streams=("camera", "lidar", "odometry", "tf"))
    robot = RobotConfig(topics=TopicCandidates(odometry=["/odom"]))
    ingest([write_recording("mcap", entries)], tmp_path / "ros", robot, IngestConfig())
    translated = [found for entry in entries if (found := _as_foxglove(entry))]
    path = _write(tmp_path / f"{encoding}.mcap", encoding, translated)
    report = ingest([path], tmp_path / "foxglove", robot, IngestConfig())
    assert report.quarantined == []
    assert report.episodes[0].topics["camera"] == "/camera/image_raw/compressed"
    ros, other = NavDataset(tmp_path / "ros"), NavDataset(tmp_path / "foxglove")
    assert len(ros) == len(other)
    for column in ("stamp_ns", "reliability.camera", "reliability.cloud"):
        np.testing.assert_array_equal(ros.column(column), other.column(column))
    np.testing.assert_array_equal(ros.points(7), other.points(7))
    np.testing.assert_array_equal(ros.image(7), other.image(7))
    np.testing.assert_allclose(other.column("observation.pose"), ros.column("observation.pose"), atol=1e-6)
    np.testing.assert_allclose(other.column("observation.state")[:, 0], 1.0, atol=1e-6)
    one, two = ros.calibration(0), other.calibration(0)
    assert one.camera == two.camera
    assert one.base_lidar is not None
    np.testing.assert_array_equal(one.base_lidar, two.base_lidar)


@pytest.mark.parametrize("encoding", ["json", "protobuf"])
def test_a_cloud_is_moved_by_its_own_pose(encoding: str, drive_entries: Callable[..., Any], tmp_path: Path) -> None:
    found = _as_foxglove(next(entry for entry in drive_entries() if entry[0] == "/points"))
    assert found is not None
    topic, kind, record_ns, fields = found
    moved = fields | {"pose": fields["pose"] | {"position": {"x": 1.0, "y": 2.0, "z": 3.0}}}
    path = _write(tmp_path / "a.mcap", encoding, [found, (topic, kind, record_ns + 1, moved)])
    with open_recording(path) as recording:
        still, shifted = (recording.decode(raw) for raw in recording.messages([topic]))
    assert isinstance(still, PointCloud)
    assert isinstance(shifted, PointCloud)
    np.testing.assert_allclose(shifted.xyz, still.xyz + np.array([1.0, 2.0, 3.0]), atol=1e-5)


def test_damage_is_one_messages_error(drive_entries: Callable[..., Any], tmp_path: Path) -> None:
    found = _as_foxglove(next(entry for entry in drive_entries() if entry[0].endswith("compressed")))
    assert found is not None
    for encoding in ("json", "protobuf"):
        with open_recording(_write(tmp_path / f"{encoding}.mcap", encoding, [found])) as recording:
            (raw,) = recording.messages([found[0]])
            for data in (b"", b"{", raw.data[:40], b"\xff" * 60):
                with pytest.raises(DatasetsError, match=r"decoded|neither JPEG nor PNG|truncated"):
                    recording.decode(raw._replace(data=data))
    fields = {"timestamp": {"sec": 1, "nanosec": 0}, "frame_id": "c", "format": "h264", "data": "AAAAAUEA"}
    video = [("/video", "CompressedVideo", 10**9, fields)]
    path = _write(tmp_path / "video.mcap", "json", video)
    report = ingest([path], tmp_path / "out", RobotConfig(), IngestConfig())
    assert "a video stream of h264 without a key frame" in report.quarantined[0].reason
