"""Stop and intervention flags of which true is good, or that are true while the robot drives."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from ingesting import ingested
from noted import noted
from turning_drive import START_NS, Entry, TurningDrive

from navtool.datasets.inspect.inspection import inspect_recording, robot_from
from navtool.datasets.robot.config import InterventionFlag, RobotConfig
from navtool.datasets.store.reader import NavDataset
from navtool.datasets.streams.flag_sense import says_good

type Write = Callable[..., Path]


def drive(topic: str, up: Callable[[float], bool]) -> list[Entry]:
    """A drive of five seconds that ends standing, with a flag."""
    entries = TurningDrive(seconds=5.0, streams=("camera", "odometry")).entries()
    last = [entry for entry in entries if entry[0] == "/odom"][-1][3]
    for number in range(1, 60):
        stamp_ns = START_NS + 5 * 10**9 + number * 50_000_000
        header = {"header": {"stamp": {"sec": stamp_ns // 10**9, "nanosec": stamp_ns % 10**9}, "frame_id": "odom"}}
        entries.append(("/odom", "nav_msgs/msg/Odometry", stamp_ns + 5_000_000, {**last, **header, "twist": {}}))
    for number in range(80):
        fields = {"data": up(number / 10)}
        entries.append((topic, "std_msgs/msg/Bool", START_NS + number * 100_000_000 + 2_000_000, fields))
    return sorted(entries, key=lambda entry: entry[2])


def standing(time_s: float) -> bool:
    return time_s >= 5.2


def driving(time_s: float) -> bool:
    return not standing(time_s)


def always(_: float) -> bool:
    return True


@pytest.mark.parametrize(
    ("topic", "up", "code", "stopped"),
    [
        ("/e_stop", standing, "", True),
        ("/e_stop_ok", driving, "flag.inverted", True),
        ("/emergency_stop/released", driving, "flag.inverted", True),
        ("/estop_enabled", driving, "flag.inverted", True),
        ("/e_stop", driving, "flag.inverted", True),
        ("/e_stop_ok", standing, "flag.inverted", True),
        ("/e_stop", always, "flag.left-out", None),
        ("/manual_override", driving, "flag.left-out", None),
        ("/manual_override", standing, "", True),
    ],
)
def test_a_flag_is_up_while_the_robot_stands(
    write_recording: Write, tmp_path: Path, topic: str, up: Callable[[float], bool], code: str, stopped: bool | None
) -> None:
    (episode,) = ingested([write_recording("mcap", drive(topic, up))], tmp_path / "out").episodes
    for other in ("flag.inverted", "flag.left-out"):
        assert len(noted(episode.notes, other)) == (other == code)
    file = NavDataset(tmp_path / "out").layout.episode(0) / "streams" / "intervention.parquet"
    assert file.exists() == (stopped is not None)
    if stopped is not None:
        active = pq.read_table(file).column("active").to_numpy()
        assert active[:50].max() == 0
        assert active[55:].min() == 1


def test_the_robot_file_has_the_word(write_recording: Write, tmp_path: Path) -> None:
    path = write_recording("mcap", drive("/e_stop_ok", driving))
    for inverted, first in ((True, 0), (False, 1)):
        robot = RobotConfig(intervention=InterventionFlag(inverted=inverted))
        out = tmp_path / f"out-{inverted}"
        (episode,) = ingested([path], out, robot=robot).episodes
        assert not noted(episode.notes, "flag.inverted")
        table = pq.read_table(NavDataset(out).layout.episode(0) / "streams" / "intervention.parquet")
        assert table.column("active").to_numpy()[0] == first


def test_inspect_writes_the_sense_into_the_robot_file(write_recording: Write) -> None:
    good = inspect_recording(write_recording("mcap", drive("/e_stop_ok", driving), "good"))
    assert robot_from(RobotConfig(), good).intervention.inverted is True
    plain = inspect_recording(write_recording("mcap", drive("/e_stop", standing), "plain"))
    assert robot_from(RobotConfig(), plain).intervention.inverted is None


def test_names_that_say_good_are_told_from_those_that_do_not() -> None:
    good = ("/e_stop_ok", "/safety/estop/released", "/estop_healthy", "/emergency/clear", "/e_stop_enabled")
    other = (
        "/e_stop",
        "/manual_enabled",
        "/intervention",
        "/emergency_stop_pressed",
        "/lookout/takeover",
        "/offroad/estop",
    )
    np.testing.assert_array_equal([says_good(name) for name in (*good, *other)], [True] * 5 + [False] * 6)
