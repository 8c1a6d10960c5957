"""Recordings of a robot's own state alone become data sets too, which upstream opens."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet as pq
import pytest
from ingesting import ingested

from navtool.datasets.check import Severity, check_dataset
from navtool.datasets.store.reader import NavDataset

type Make = Callable[..., Any]
NATIVE_HZ = {"imu": 100, "joints": 50, "battery": 2, "odometry": 50}


@pytest.mark.parametrize(
    "streams",
    [("imu",), ("joints",), ("battery",), ("odometry",), ("imu", "battery"), ("joints", "imu", "command")],
    ids="+".join,
)
def test_state_alone_becomes_rows(
    streams: tuple[str, ...], drive_entries: Make, recording_writer: Make, tmp_path: Path
) -> None:
    recording = recording_writer(tmp_path, "mcap", drive_entries(3.0, streams=streams))
    report = ingested([recording], tmp_path / "out")
    assert not report.quarantined, report.quarantined
    (episode,) = report.episodes
    spans = next(stream for stream in ("odometry", "imu", "joints", "battery") if stream in streams)
    assert episode.sync["grid_stream"] == spans
    assert episode.rows == pytest.approx(3 * 10, abs=6)
    data = NavDataset(tmp_path / "out")
    for stream in streams:
        column = {"odometry": "state", "command": "action"}.get(stream, stream)
        assert np.asarray(data.column(f"valid.{column}")).mean() > 0.9
    for stream in set(streams) & set(NATIVE_HZ):
        (native,) = (tmp_path / "out").glob(f"**/streams/{stream}.parquet")
        assert pq.read_metadata(native).num_rows == 3 * NATIVE_HZ[stream]
    failed = [x for x in check_dataset(tmp_path / "out").findings if x.severity is Severity.FAIL]
    assert not failed


def test_upstream_opens_them(
    assert_upstream_opens: Callable[[Path], None], drive_entries: Make, recording_writer: Make, tmp_path: Path
) -> None:
    entries = drive_entries(2.0, streams=("imu", "joints", "battery"))
    ingested([recording_writer(tmp_path, "mcap", entries)], tmp_path / "out")
    assert_upstream_opens(tmp_path / "out")


def test_commands_alone_are_nothing_to_learn_from(drive_entries: Make, recording_writer: Make, tmp_path: Path) -> None:
    entries = drive_entries(2.0, streams=("command", "tf"))
    (refused,) = ingested([recording_writer(tmp_path, "mcap", entries)], tmp_path / "out").quarantined
    assert "an IMU, joints or a battery" in refused.reason
