"""The sign of a discharge where the robot file leaves it open: that of the recording's median current."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from noted import noted

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.battery_sign import discharge_sign
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.rows import BATTERY_COLUMNS
from navtool.datasets.streams.timed_stream import TimedStream


def battery(currents: list[float]) -> TimedStream:
    recorded = RecordedStream(
        "/battery", rows=[(current, np.nan, np.nan) for current in currents], columns=BATTERY_COLUMNS
    )
    order = np.arange(len(currents))
    return TimedStream.of(recorded, StreamTime(order, order, "record"))


CURRENTS = st.lists(st.floats(-80, 80) | st.just(np.nan), min_size=1, max_size=30)


@given(currents=CURRENTS, configured=st.sampled_from([-1, 1]))
def test_a_sign_that_the_robot_file_names_stays(currents: list[float], configured: int) -> None:
    assert discharge_sign(configured, battery(currents)) == (configured, ())


@given(currents=CURRENTS)
def test_most_of_the_time_the_robot_draws(currents: list[float]) -> None:
    sign, notes = discharge_sign(0, battery(currents))
    assert sign in (-1, 1)
    discharges = sign * np.array(currents)
    finite = discharges[np.isfinite(discharges)]
    if finite.size:
        assert np.median(finite) >= 0
        assert len(notes) == 1
    else:
        assert notes == (), "that nothing was measured is told elsewhere"


@given(currents=CURRENTS)
def test_a_battery_that_counts_the_other_way_has_the_other_sign(currents: list[float]) -> None:
    one, other = discharge_sign(0, battery(currents)), discharge_sign(0, battery([-value for value in currents]))
    finite = np.array([value for value in currents if np.isfinite(value)])
    assert other.sign == (-one.sign if finite.size and np.median(finite) != 0 else one.sign)


@pytest.mark.parametrize("sign", [-1, 1])
def test_the_column_is_positive_and_a_note_says_why(
    sign: int, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    entries = [
        (topic, kind, time, fields | {"current": sign * 4.0} if topic == "/battery_state" else fields)
        for topic, kind, time, fields in drive_entries(2.0, streams=("odometry", "battery"))
    ]
    robot = RobotConfig(battery_current_sign=0)
    report = ingest([write_recording("mcap", entries)], tmp_path / "out", robot, IngestConfig())
    assert NavDataset(tmp_path / "out").column("observation.proprioception")[5, -1] == pytest.approx(4.0)
    said = f"battery: the robot file leaves the sign of a discharge open; the median of {sign * 4.0} A is taken for one"
    assert noted(report.episodes[0].notes, "battery.sign-by-median") == [said]
