"""Clocks of sensors that are apart: what cannot be latency is corrected and said, what may be is only said."""

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from noted import noted
from planning import planned
from turning_drive import TurningDrive

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.streams.clock_offsets import OffsetPolicy
from navtool.datasets.streams.config import StreamSync, SyncConfig
from navtool.datasets.streams.sync import Method

type Write = Callable[..., Path]
COUNT = itertools.count()


def plan_of(write: Write, drive: TurningDrive, sync: SyncConfig | None = None) -> EpisodePlan:
    return planned(write("mcap", drive.entries(), f"bag-{next(COUNT)}"), sync=sync or SyncConfig())


def side_by_side(plan: EpisodePlan, stream: str) -> float:
    """The largest difference, in messages, between a stream's and the camera's at the same tick; both come at 10 Hz."""
    of_tick = {name: numbers(plan, name) for name in (stream, "camera")}
    both = of_tick[stream].keys() & of_tick["camera"].keys()
    assert len(both) > plan.ticks_ns.size / 2
    return max(abs(of_tick[stream][tick] - of_tick["camera"][tick]) for tick in both)


def numbers(plan: EpisodePlan, stream: str) -> dict[int, int]:
    """Which message of a stream, counted in the order of its stamps, serves each tick."""
    large = plan.large[stream]
    rank = {n: rank for rank, n in enumerate(sorted(large.stamps_ns, key=large.stamps_ns.__getitem__))}
    return {tick: rank[n] for n, ticks in large.episode_ticks.items() for tick in ticks}


def reported(plan: EpisodePlan, stream: str, key: str) -> Any:
    """What the sync report says of a stream."""
    streams: Any = plan.sync_report["streams"]
    return streams[stream][key]


def all_notes(plan: EpisodePlan, code: str) -> list[str]:
    return noted([*plan.notes, *plan.time_notes], code)


def test_clocks_that_agree_are_left_alone(write_recording: Write) -> None:
    plan = plan_of(write_recording, TurningDrive())
    assert not all_notes(plan, "clock.offset")
    assert not all_notes(plan, "clock.offset-suspected")
    motion = reported(plan, "odometry", "motion")
    assert motion["against"] == "imu"
    assert abs(motion["ahead_s"]) < 0.01
    assert motion["correlation"] > 0.95


@pytest.mark.parametrize("turns", [True, False])
@pytest.mark.parametrize("seconds", [-0.8, -37.0, 37.0, 18.0, 0.3, 3600.0, -1_749_999_000.0, 5.2])
def test_lidar_other_clock(write_recording: Write, seconds: float, turns: bool) -> None:
    plan = plan_of(write_recording, TurningDrive(header_s={"lidar": seconds}, turns=turns))
    assert side_by_side(plan, "lidar") == 0
    stamps_ns = np.array(sorted(plan.large["lidar"].stamps_ns.values()))
    assert np.abs(stamps_ns - plan.ticks_ns[: stamps_ns.size]).max() < 30_000_000
    (note,) = all_notes(plan, "clock.offset")
    assert f"{abs(seconds):.0f}" in note or f"{abs(seconds):.1f}" in note
    assert ("ahead of" if seconds > 0 else "behind") in note
    assert abs(reported(plan, "lidar", "clock_offset")["added_s"] + seconds) < 0.03


@pytest.mark.parametrize("stream", ["camera", "imu", "odometry"])
def test_any_other_sensor_may_be_the_one(write_recording: Write, stream: str) -> None:
    plan = plan_of(write_recording, TurningDrive(header_s={stream: -0.7}))
    assert abs(reported(plan, stream, "clock_offset")["added_s"] - 0.7) < 0.03
    assert len(all_notes(plan, "clock.offset")) == 1
    assert side_by_side(plan, "lidar") == 0
    assert plan.columns["valid.state"].mean() > 0.9
    assert plan.columns["valid.imu"].mean() > 0.9


def test_two_sensors_of_one_other_clock_keep_what_lies_between_them(write_recording: Write) -> None:
    drive = TurningDrive(header_s={"lidar": -2.31, "imu": -2.27}, late_s={"lidar": 0.05}, turns=False)
    plan = plan_of(write_recording, drive)
    assert reported(plan, "lidar", "clock_offset")["added_s"] == reported(plan, "imu", "clock_offset")["added_s"]


def test_a_camera_that_is_compressed_arrives_late_and_is_right(write_recording: Write) -> None:
    drive = TurningDrive(late_s={"camera": 0.15}, jitter_s={"camera": 0.02})
    plan = plan_of(write_recording, drive)
    assert side_by_side(plan, "lidar") == 0
    assert not all_notes(plan, "clock.offset")
    assert not all_notes(plan, "clock.offset-suspected")
    assert abs(reported(plan, "camera", "motion")["ahead_s"]) < 0.05


def test_where_nothing_turns_a_late_camera_is_only_suspect(write_recording: Write) -> None:
    plan = plan_of(write_recording, TurningDrive(late_s={"camera": 0.25}, turns=False))
    assert side_by_side(plan, "lidar") == 0
    assert not all_notes(plan, "clock.offset")
    assert len(all_notes(plan, "clock.offset-suspected")) == 1


@pytest.mark.parametrize("stream", ["camera", "lidar"])
def test_what_may_be_latency_is_told_by_the_motion(write_recording: Write, stream: str) -> None:
    plan = plan_of(write_recording, TurningDrive(header_s={stream: -0.3}))
    (note,) = all_notes(plan, "clock.offset")
    assert "turning" in note
    assert side_by_side(plan, "lidar") == 0


def test_a_queue_that_is_late_is_no_clock(write_recording: Write) -> None:
    drive = TurningDrive(late_s={"lidar": 0.6}, jitter_s={"lidar": 1.5}, turns=False)
    plan = plan_of(write_recording, drive)
    assert not all_notes(plan, "clock.offset")
    assert side_by_side(plan, "lidar") == 0


def test_a_clock_that_drifts_is_brought_back_at_both_ends(write_recording: Write) -> None:
    drive = TurningDrive(seconds=25.0, header_s={"lidar": 5.0}, drift={"lidar": 0.003}, turns=False)
    plan = plan_of(write_recording, drive)
    assert side_by_side(plan, "lidar") == 0
    assert "ppm" in all_notes(plan, "clock.offset")[0]


def test_commands_without_header_follow_where_all_headers_are_apart(write_recording: Write) -> None:
    streams = ("camera", "lidar", "odometry", "imu")
    plan = plan_of(write_recording, TurningDrive(header_s=dict.fromkeys(streams, -0.6)))
    expected = plan_of(write_recording, TurningDrive())
    assert not all_notes(plan, "clock.offset")
    # A command counts from 5 ms before its time of record on: from the tick itself, no more behind it.
    np.testing.assert_allclose(plan.columns["action"][5:100], expected.columns["action"][6:101], atol=1e-5)


def with_offset(seconds: float, **more: Any) -> SyncConfig:
    return SyncConfig(lidar=StreamSync(method=Method.nearest, tolerance_s=0.06, offset_s=seconds), **more)


def test_an_offset_set_by_hand_is_what_is_added(write_recording: Write) -> None:
    plan = plan_of(write_recording, TurningDrive(header_s={"lidar": -0.2}, turns=False), with_offset(0.2))
    assert side_by_side(plan, "lidar") == 0
    assert not all_notes(plan, "clock.offset-suspected")
    kept = plan_of(write_recording, TurningDrive(header_s={"lidar": -0.8}), with_offset(0.0))
    assert side_by_side(kept, "lidar") == 8


@pytest.mark.parametrize("policy", [OffsetPolicy.refuse, OffsetPolicy.keep])
def test_the_policy_may_be_another(write_recording: Write, policy: OffsetPolicy) -> None:
    drive, sync = TurningDrive(header_s={"lidar": -0.8}, turns=False), SyncConfig(offsets=policy)
    if policy is OffsetPolicy.refuse:
        with pytest.raises(DatasetsError, match=r"0\.800 s behind") as refused:
            plan_of(write_recording, drive, sync)
        assert "sync.lidar.offset_s=0.800" in (refused.value.cure or "")
        return
    plan = plan_of(write_recording, drive, sync)
    assert side_by_side(plan, "lidar") == 8
    assert "sync.lidar.offset_s=0.800" in all_notes(plan, "clock.offset")[0]
