"""Several cameras: all are proposed, and the one that looks ahead is the first."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from noted import noted
from turning_drive import START_NS, Entry, TurningDrive

from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.front_camera import recorded_topic_map
from navtool.datasets.robot.topic_map import TopicMap

type Write = Callable[..., Path]
RIG = ("front", "front_left", "front_right", "left", "rear")
IMAGE, INFO = "sensor_msgs/msg/Image", "sensor_msgs/msg/CameraInfo"


def looks(yaw_deg: float, *, optical: bool = True) -> dict[str, float]:
    """The attitude of a camera that looks so far to the left of ahead; of an optical frame, or of one with x ahead."""
    half = np.radians(yaw_deg) / 2
    z, w = np.sin(half), np.cos(half)
    if not optical:
        return {"z": float(z), "w": float(w)}
    return _optical(float(z), float(w))


def _optical(z: float, w: float) -> dict[str, float]:
    """A turn about z, times the optical frame's own attitude (-0.5, 0.5, -0.5, 0.5)."""
    x2, y2, z2, w2 = -0.5, 0.5, -0.5, 0.5
    return {
        "x": float(w * x2 - z * y2),
        "y": float(w * y2 + z * x2),
        "z": float(w * z2 + z * w2),
        "w": float(w * w2 - z * z2),
    }


def rig(names: tuple[str, ...], poses: dict[str, dict[str, float]]) -> list[Entry]:
    entries = TurningDrive(seconds=1.0, streams=("odometry",)).entries()[1:]

    def header(frame: str) -> dict[str, Any]:
        return {"header": {"stamp": {"sec": START_NS // 10**9, "nanosec": 0}, "frame_id": frame}}

    transforms = [
        {**header("base_link"), "child_frame_id": name, "transform": {"rotation": rotation}}
        for name, rotation in poses.items()
    ]
    entries.append(("/tf_static", "tf2_msgs/msg/TFMessage", START_NS, {"transforms": transforms}))
    pixels = {"height": 2, "width": 2, "encoding": "rgb8", "step": 6, "data": np.full(12, 90)}
    depth = {"height": 2, "width": 2, "encoding": "16UC1", "step": 4, "data": np.full(8, 9)}
    for number in range(3):
        for name in names:
            at = START_NS + number * 100_000_000
            entries.append((f"/{name}/image_raw", IMAGE, at, {**header(name), **pixels}))
            entries.append((f"/{name}/camera_info", INFO, at, {**header(name), "height": 2, "width": 2}))
        entries.append((f"/{names[0]}/depth/image_raw", IMAGE, at, {**header(names[0]), **depth}))
    return sorted(entries, key=lambda entry: entry[2])


def topics_of(write: Write, entries: list[Entry], robot: RobotConfig | None = None) -> TopicMap:
    with open_recording(write("mcap", entries)) as recording:
        return recorded_topic_map(robot or RobotConfig(), recording)


def test_camera_rig(write_recording: Write) -> None:
    found = topics_of(write_recording, rig(RIG, {}))
    assert found.streams["camera"] == "/front/image_raw"
    further = {topic for stream, topic in found.further.items() if stream.startswith("camera.")}
    assert further == {f"/{name}/image_raw" for name in RIG[1:]}
    assert next(unused.reason for unused in found.not_used if "depth" in unused.name).startswith("a depth")
    assert len(noted(found.notes, "topics.front-by-name")) == 1


@pytest.mark.parametrize(
    "names", [("cam_left_front", "cam_front", "cam_right_front"), ("rig/frontleft", "rig/front_center")]
)
def test_plain_front_comes_before_its_sides(write_recording: Write, names: tuple[str, ...]) -> None:
    assert topics_of(write_recording, rig(names, {})).streams["camera"] == f"/{names[1]}/image_raw"


@pytest.mark.parametrize("optical", [True, False])
def test_where_a_camera_looks_counts_before_its_name(write_recording: Write, optical: bool) -> None:
    poses = {
        "front": looks(180, optical=optical),
        "cam1": looks(5, optical=optical),
        "cam2": looks(-90, optical=optical),
    }
    found = topics_of(write_recording, rig(("front", "cam1", "cam2"), poses))
    assert found.streams["camera"] == "/cam1/image_raw"
    assert len(noted(found.notes, "topics.front-by-tf")) == 1


def test_where_both_agree_nothing_is_said(write_recording: Write) -> None:
    found = topics_of(write_recording, rig(("front", "rear"), {"front": looks(3), "rear": looks(180)}))
    assert found.streams["camera"] == "/front/image_raw"
    assert not noted(found.notes, "topics.front-by-tf")
    assert not noted(found.notes, "topics.front-by-name")
