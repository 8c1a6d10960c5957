"""A stream that cannot be read sinks no recording."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from field_drives import camera_drive, picture, raw
from ingesting import ingested
from noted import noted

from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.sensor_config import FurtherCamera

type Make = Callable[..., Any]
BAD: dict[str, dict[str, Any]] = {
    "an encoding of its own": {"encoding": "vendor12p"},
    "fewer bytes than pixels": {"data": np.zeros(7)},
    "depth": {"encoding": "16UC1"},
}


@pytest.mark.parametrize("change", BAD.values(), ids=BAD)
def test_a_camera_that_cannot_be_decoded_is_left_out_named_and_counted(
    change: dict[str, Any], recording_writer: Make, tmp_path: Path
) -> None:
    entries = camera_drive(lambda k, t: raw(t, picture(k), "rgb8") | change, streams=("odometry", "lidar", "tf"))
    recording = recording_writer(tmp_path, "mcap", entries)
    (episode,) = ingested([recording], tmp_path / "out").episodes
    assert episode.rows > 10
    assert "camera" not in episode.sync["streams"]
    (note,) = noted(episode.notes, "stream.undecodable")
    assert "camera: not one of 12 messages on /camera/image_raw" in note
    assert episode.dropped["camera: cannot be decoded"] == 12
    (refused,) = ingested([recording], tmp_path / "strict", strict=True).quarantined
    assert "camera cannot be decoded" in refused.reason


def test_a_further_camera_and_a_lidar_are_left_out_alike(recording_writer: Make, tmp_path: Path) -> None:
    entries = camera_drive(lambda k, t: raw(t, picture(k), "rgb8"), streams=("odometry", "lidar", "tf"))
    rear = camera_drive(lambda k, t: raw(t, picture(k), "odd"), topic="/rear/image_raw", streams=())
    broken = [
        (topic, kind, t, fields | {"fields": []} if topic == "/points" else fields)
        for topic, kind, t, fields in entries
    ]
    recording = recording_writer(tmp_path, "mcap", sorted([*broken, *rear], key=lambda entry: entry[2]))
    robot = RobotConfig(cameras={"rear": FurtherCamera(topics=["/rear/image_raw"])})
    (episode,) = ingested([recording], tmp_path / "out", robot=robot, allow_missing=True).episodes
    assert set(episode.sync["streams"]) == {"camera", "odometry"}
    assert len(noted(episode.notes, "stream.undecodable")) == 2


def test_without_any_other_stream_the_reason_is_its_own(recording_writer: Make, tmp_path: Path) -> None:
    entries = camera_drive(lambda k, t: raw(t, picture(k), "odd"), streams=())
    (refused,) = ingested([recording_writer(tmp_path, "mcap", entries)], tmp_path / "out").quarantined
    assert "/camera/image_raw" in refused.reason
    assert "image encoding 'odd' is not supported" in refused.reason
