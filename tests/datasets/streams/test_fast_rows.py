"""Rows straight from the bytes are the decoders' rows, for any content, in every serialisation; or there are none."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import open_recording
from navtool.datasets.streams.fast_rows import FastRows
from navtool.datasets.streams.rows import StreamRows, rows_of

KINDS = {
    "imu": "sensor_msgs/msg/Imu",
    "odometry": "nav_msgs/msg/Odometry",
    "command": "geometry_msgs/msg/TwistStamped",
    "joints": "sensor_msgs/msg/JointState",
}
FRAMES = ("", "a", "ab", "abc", "abcd", "odom", "imu_link", "größe/link")


def _numbers(rng: np.random.Generator, names: str) -> dict[str, float]:
    return dict(zip(names, rng.normal(size=len(names)).tolist(), strict=True))


def _entries(rng: np.random.Generator) -> list[Any]:
    entries = []
    for number, frame in enumerate(FRAMES * 2):
        stamp = {"sec": int(rng.integers(2**31)), "nanosec": int(rng.integers(10**9))}
        head = {"header": {"stamp": stamp, "frame_id": frame}}
        twist = {"linear": _numbers(rng, "xyz"), "angular": _numbers(rng, "xyz")}
        joints = [f"joint_{'x' * n}" for n in range(number % 5 + 1)]
        values = {key: rng.normal(size=len(joints)) for key in ("position", "velocity", "effort")}
        if number == 3:
            values["effort"] = np.zeros(0)
        pose = {"position": _numbers(rng, "xyz"), "orientation": _numbers(rng, "xyzw")}
        contents: dict[str, dict[str, Any]] = {
            "imu": {
                "orientation": _numbers(rng, "xyzw"),
                "angular_velocity": _numbers(rng, "xyz"),
                "linear_acceleration": _numbers(rng, "xyz") | {"x": np.nan},
                "angular_velocity_covariance": rng.normal(size=9),
            },
            "odometry": {
                "child_frame_id": FRAMES[-number % len(FRAMES)],
                "pose": {"pose": pose, "covariance": rng.normal(size=36)},
                "twist": {"twist": twist, "covariance": rng.normal(size=36)},
            },
            "command": {"twist": twist},
            "joints": {"name": joints, **values},
        }
        entries += [(f"/{s}", KINDS[s], 10 + number, {**head, **contents[s]}) for s in KINDS]
    return entries


@pytest.mark.parametrize("container", ["ros1", "mcap", "mcap_ros1", "db3"])
def test_the_rows_are_those_of_the_decoders(container: str, write_recording: Callable[..., Path]) -> None:
    fast_ones = 0
    with open_recording(write_recording(container, _entries(np.random.default_rng(0)))) as recording:
        fast = FastRows(recording)
        for raw in recording.messages({f"/{stream}" for stream in KINDS}):
            found = fast.row(raw)
            slow = rows_of(recording.decode(raw), raw.topic[1:], None)
            if found is None:
                assert raw.topic == "/joints", "only a message whose lists differ in length is left out"
                continue
            fast_ones += 1
            assert (found.stamp_ns, found.frame_id, found.columns) == (slow.stamp_ns, slow.frame_id, slow.columns)
            assert found.joint_names == slow.joint_names
            np.testing.assert_array_equal(found.values, slow.values)
    assert fast_ones == 4 * 2 * len(FRAMES) - 1


def test_whatever_is_odd_is_left_to_the_decoders(
    write_recording: Callable[..., Path], cdr: Callable[..., bytes]
) -> None:
    text: tuple[str, str, int, dict[str, Any]] = ("/text", "std_msgs/msg/String", 11, {"data": "x"})
    entries = [*((f"/{s}", KINDS[s], 10, dict[str, Any]()) for s in KINDS), text]
    with open_recording(write_recording("mcap", entries)) as recording:
        fast = FastRows(recording)
        for raw in recording.messages({entry[0] for entry in entries}):
            for data in (b"", raw.data[:7], raw.data[:-1], raw.data + bytes(8), b"\x00\x03" + raw.data[2:]):
                assert fast.row(raw._replace(data=data)) is None
            if raw.topic == "/imu":
                big = cdr(raw.type, {"linear_acceleration": {"x": 2.0}}, little_endian=False)
                assert fast.row(raw._replace(data=big)) is None
                assert rows_of(recording.decode(raw._replace(data=big)), "imu", None).values[0] == 2.0
            if raw.topic == "/text":
                assert fast.row(raw) is None
                with pytest.raises(DatasetsError):
                    rows_of(recording.decode(raw), "imu", None)


def test_rows_are_plain_numbers(write_recording: Callable[..., Path]) -> None:
    with open_recording(write_recording("mcap", [("/imu", KINDS["imu"], 10, {})])) as recording:
        (raw,) = recording.messages(["/imu"])
        row = FastRows(recording).row(raw)
    assert isinstance(row, StreamRows)
    assert all(type(value) is float for value in row.values)
