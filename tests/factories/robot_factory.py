"""Drives as the robots of the presets record them: their topics, types, frames and traps, under any namespace."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import pytest
from drive_factory import RECORD_DELAY_NS, START_NS, Entry
from robot_messages import OTHER_TYPES, Make, spot_joints

from navtool.datasets.robot.config import RobotConfig

DRIVE = {
    "camera": "/camera/image_raw/compressed",
    "camera_info": "/camera/camera_info",
    "lidar": "/points",
    "odometry": "/odom",
    "imu": "/imu/data",
    "joints": "/joint_states",
    "battery": "/battery_state",
    "command": "/cmd_vel",
    "intervention": "/operator/intervention",
}
"""The streams' topics in the drives of the tests."""
LACKING: dict[str, set[str]] = {
    "m2dgr": {"odometry", "joints", "battery", "command", "camera_info"},
    "rellis3d": {"joints"},
    "tartandrive1": {"lidar", "camera_info", "joints", "battery"},
    "tartandrive2": {"camera_info", "joints", "battery"},
    "scand_jackal": {"imu", "camera_info", "joints", "battery"},
    "scand_spot": {"imu", "camera_info", "joints", "battery"},
    "fusionportable_v2": {"command"},
    "paad": {"camera_info"},
}
"""What the recordings of a preset do not have."""


class _Entry(NamedTuple):
    topic: str
    type: str
    record_ns: int
    fields: dict[str, Any]


class RobotDrive(NamedTuple):
    """The messages, and the topic of each stream that ingest should find."""

    entries: list[Entry]
    topics: dict[str, str]


@pytest.fixture(scope="session")
def robot_drive(drive_entries: Callable[..., list[Entry]]) -> Callable[..., RobotDrive]:
    """``robot_drive(name, robot, seconds=2.0, ros1=, namespace="/r1", other_types={}, streams=None)``.

    The drive as the preset's robot records it: of each stream the first candidate, those without a leading slash under
    the namespace.
    """

    def drive(
        name: str,
        robot: RobotConfig,
        seconds: float = 2.0,
        *,
        ros1: bool,
        namespace: str = "/r1",
        other_types: Mapping[str, tuple[str, Make]] | None = None,
        streams: tuple[str, ...] | None = None,
    ) -> RobotDrive:
        topics = _topics(name, robot, namespace)
        carrier: dict[str, str] = {}
        for stream, topic in topics.items():
            carrier.setdefault(topic, stream)  # one message feeds all streams of its topic
        others = {stream: made for (preset, stream), made in OTHER_TYPES.items() if preset == name}
        others |= other_types or {}
        stream_of = {usual: stream for stream, usual in DRIVE.items()}
        out = []
        for usual in drive_entries(seconds, ros1=ros1, **({} if streams is None else {"streams": streams})):
            entry = _Entry(*usual)
            stream = stream_of.get(entry.topic, "tf")
            if stream == "tf":
                under = namespace if robot.name == "clearpath" else ""
                out.append(entry._replace(topic=f"{under}{entry.topic}", fields=_tf(entry.fields, robot)))
            elif carrier.get(topics.get(stream, "")) == stream:
                entry = _made(entry, others.get(stream), ros1=ros1)
                if stream == "joints" and robot.joint_names:
                    entry = entry._replace(fields=entry.fields | spot_joints(robot.joint_names))
                out.append(entry._replace(topic=topics[stream]))
        written = {entry.topic for entry in out}
        return RobotDrive(
            [(x.topic, x.type, x.record_ns, x.fields) for x in out],
            {stream: topic for stream, topic in topics.items() if topic in written},
        )

    return drive


def _topics(name: str, robot: RobotConfig, namespace: str) -> dict[str, str]:
    topics: dict[str, str] = {}
    for stream, usual in DRIVE.items():
        wanted = getattr(robot.topics, stream)
        if wanted != ["none"] and stream not in LACKING.get(name, set()):
            first = wanted[0] if wanted else usual
            topics[stream] = first if first.startswith("/") else f"{namespace}/{first}"
    return topics


def _tf(fields: dict[str, Any], robot: RobotConfig) -> dict[str, Any]:
    moved = [t | {"header": t["header"] | {"frame_id": robot.base_frame}} for t in fields["transforms"]]
    return {"transforms": moved}


def _made(entry: "_Entry", other: tuple[str, Make] | None, *, ros1: bool) -> "_Entry":
    if other is None:
        return entry
    stamp_ns = entry.record_ns - RECORD_DELAY_NS
    stamp = {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}
    header = {"stamp": stamp, "frame_id": entry.fields.get("header", {}).get("frame_id", "")}
    kind, make = other
    fields = make({"header": header | ({"seq": 0} if ros1 else {})}, (stamp_ns - START_NS) * 1e-9)
    return entry._replace(type=kind, fields=fields)
