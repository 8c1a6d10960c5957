"""The older cloud with channels against a loop over its points, by the real writers."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.channel_cloud import decode_channel_cloud
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig, TopicCandidates

CLOUD = "sensor_msgs/msg/PointCloud"
STAMP_NS = 1_700_000_000_250_000_000
HEAD = {"header": {"stamp": {"sec": STAMP_NS // 10**9, "nanosec": STAMP_NS % 10**9}, "frame_id": "sensor"}}
type Make = Callable[..., Any]


def cloud_fields(points: int, channels: dict[str, list[float]]) -> dict[str, Any]:
    return {
        **HEAD,
        "points": [{"x": k + 0.5, "y": -2.0 * k, "z": 0.25 * k} for k in range(points)],
        "channels": [{"name": name, "values": values} for name, values in channels.items()],
    }


@pytest.mark.parametrize("container", ["ros1", "db3", "mcap"])
def test_through_the_real_writers(container: str, write_recording: Callable[..., Path]) -> None:
    channels: dict[str, list[float]] = {
        "rgb": [1.0] * 5,
        "Intensity": [10.0, 11.0, 12.0, 13.0, 14.0],
        "ring": [0.0, 1.0, 2.0, 3.0, 4.0],
        "time": [0.0, 0.1, 0.2, 0.3, 0.4],
    }
    fields = cloud_fields(5, channels)
    fields["points"][2]["y"] = math.nan
    path = write_recording(container, [("/cloud", CLOUD, STAMP_NS, fields)])
    with open_recording(path) as recording:
        (raw,) = recording.messages(["/cloud"])
        cloud = recording.decode(raw)
        assert isinstance(cloud, PointCloud)
        kept = [0, 1, 3, 4]
        assert cloud.xyz.tolist() == [[k + 0.5, -2.0 * k, 0.25 * k] for k in kept]
        assert cloud.intensity is not None
        assert cloud.ring is not None
        assert cloud.time_s is not None
        assert cloud.intensity.tolist() == [10 + k for k in kept]
        assert cloud.ring.tolist() == kept
        np.testing.assert_allclose(cloud.time_s, [0.1 * k for k in kept], rtol=1e-6)
        assert (cloud.stamp_ns, cloud.frame_id, cloud.dropped_nonfinite) == (STAMP_NS, "sensor", 1)
        for size in range(len(raw.data)):
            with pytest.raises(DatasetsError, match="/cloud"):
                recording.decode(raw._replace(data=raw.data[:size]))


def test_channels_that_are_missing_or_empty(ros_message: Make) -> None:
    for channels in ({}, {"intensity": [], "ring": [], "stamps": [1.0, 2.0]}):
        cloud = decode_channel_cloud(ros_message(CLOUD, cloud_fields(2, channels)))
        assert (cloud.intensity, cloud.ring, cloud.time_s) == (None, None, None)
    assert decode_channel_cloud(ros_message(CLOUD, cloud_fields(0, {}))).xyz.shape == (0, 3)


def test_a_channel_of_another_length_is_refused_where_it_is_used(ros_message: Make) -> None:
    with pytest.raises(DatasetsError, match="a channel of 3 values beside 2 points"):
        decode_channel_cloud(ros_message(CLOUD, cloud_fields(2, {"intensity": [1.0, 2.0, 3.0]})))
    decode_channel_cloud(ros_message(CLOUD, cloud_fields(2, {"curvature": [1.0, 2.0, 3.0]})))


def test_it_is_taken_only_where_it_is_named(write_recording: Callable[..., Path], tmp_path: Path) -> None:
    """Such a topic may as well hold a camera's features."""
    at = [STAMP_NS + k * 100_000_000 for k in range(5)]
    stamps = [{"sec": t // 10**9, "nanosec": t % 10**9} for t in at]
    entries = [
        ("/cloud", CLOUD, t, {**cloud_fields(20, {}), "header": {"stamp": stamp, "frame_id": "sensor"}})
        for t, stamp in zip(at, stamps, strict=True)
    ]
    path = write_recording("ros1", entries)
    guessed = ingest([path], tmp_path / "guessed", RobotConfig(), IngestConfig())
    assert "name it as lidar in the robot file" in guessed.quarantined[0].reason
    named = RobotConfig(topics=TopicCandidates(lidar=["/cloud"]))
    report = ingest([path], tmp_path / "named", named, IngestConfig())
    assert [episode.rows for episode in report.episodes] == [5]
