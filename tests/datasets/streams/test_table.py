"""The tables of streams and messages agree with each other, and the settings with them."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest

from navtool.base.setting_error import SettingError
from navtool.datasets.decode.table import MESSAGES, TRANSFORMS, proposed_types, readable_types
from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.robot.config import TopicCandidates
from navtool.datasets.robot.recorded_geometry import RecordedGeometry
from navtool.datasets.streams.clock import Clock
from navtool.datasets.streams.config import StreamSync, SyncConfig
from navtool.datasets.streams.rows import rows_of
from navtool.datasets.streams.table import GRIDDED, POSED, SMALL, STREAMS, Kind, is_large

_CLOCKED = tuple(name for name, row in STREAMS.items() if row.kind is not Kind.geometry)


def test_the_robots_topics_are_the_streams_in_their_order() -> None:
    assert tuple(entry.name for entry in fields(TopicCandidates)) == tuple(STREAMS)


def test_sync_has_a_setting_for_every_stream_with_the_tables_default() -> None:
    config = SyncConfig()
    assert tuple(entry.name for entry in fields(SyncConfig) if entry.name in STREAMS) == _CLOCKED
    for name in _CLOCKED:
        setting, default = getattr(config, name), STREAMS[name].sync
        assert config.of(name) is (None if default is None else setting)
        assert isinstance(setting, StreamSync) == (default is not None)
        assert config.clock_of(name) is Clock.auto
        if default is not None:
            assert (setting.method, setting.tolerance_s) == (default.method, default.tolerance_s)


@pytest.mark.parametrize("name", GRIDDED)
def test_a_tolerance_out_of_range_is_refused_for_every_stream_on_the_grid(name: str) -> None:
    with pytest.raises(SettingError, match="tolerance_s: 61 s is outside"):
        replace(getattr(SyncConfig(), name), tolerance_s=61.0)


def test_every_message_feeds_streams_that_there_are_and_every_stream_is_fed() -> None:
    known = {*STREAMS, TRANSFORMS}
    for row in MESSAGES.values():
        assert {*row.proposed, *row.named} <= known, row.type
        assert not set(row.proposed) & set(row.named), row.type
        assert not (row.unused and row.proposed), f"{row.type}: a reason that is never given"
    for stream in known:
        assert proposed_types(stream)
        assert set(readable_types(stream)) == {
            row.type for row in MESSAGES.values() if stream in (*row.proposed, *row.named)
        }


def test_a_row_of_every_small_stream_has_the_tables_columns(ros_message: Callable[..., Any]) -> None:
    given = {
        "sensor_msgs/msg/Imu": "imu",
        "nav_msgs/msg/Odometry": "odometry",
        "sensor_msgs/msg/BatteryState": "battery",
        "geometry_msgs/msg/Twist": "command",
        "std_msgs/msg/Bool": "intervention",
    }
    assert {*given.values(), "joints"} == set(SMALL)
    for kind, stream in given.items():
        sample = MESSAGES[kind].decode(ros_message(kind, {}))
        rows = rows_of(sample, stream, None)
        assert rows.columns == STREAMS[stream].columns
        assert len(rows.values) == len(rows.columns)


def test_poses_are_fields_of_the_calibration_by_their_streams() -> None:
    matrices: dict[str, Any] = {STREAMS[stream].pose: np.eye(4) * (number + 1) for number, stream in enumerate(POSED)}
    calibration = Calibration(
        camera=None,
        base_height_m=0.0,
        robot_width_m=0.5,
        sources={},
        recorded=RecordedGeometry(),
        further={},
        **matrices,
    )
    assert POSED == ("camera", "lidar", "imu", "odometry"), "the order in calibration.json"
    assert {stream for stream in STREAMS if is_large(stream)} <= set(POSED)
    for stream, pose in calibration.poses().items():
        assert pose is matrices[STREAMS[stream].pose]
