"""Labels that cannot be: check says so, whichever rule or flag made them."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ingesting import ingested
from odometry_drives import START_NS, OdometryDrive, odometry_drive, odometry_entries

from navtool.datasets.check import Severity, check_dataset
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import InterventionFlag, RobotConfig

type Write = Callable[..., Path]


def stop_and_go() -> OdometryDrive:
    """Ten seconds of driving, five of standing, four times."""
    drive = odometry_drive("straight", seconds=60.0, hz=10.0)
    goes = drive.time_s % 15 < 10
    drive.values[:, 7] = goes
    drive.values[1:, 0] = np.cumsum((goes[1:] * 1.0 + goes[:-1]) / 2 * 0.1) * np.cos(0.3)
    drive.values[1:, 1] = np.cumsum((goes[1:] * 1.0 + goes[:-1]) / 2 * 0.1) * np.sin(0.3)
    return drive


def judged(
    write: Write, out: Path, flag: Callable[[OdometryDrive], Any], events: str = ""
) -> list[tuple[Severity, str]]:
    """What check says of the labels of a stop-and-go drive with an operator's flag."""
    drive = stop_and_go()
    flags = [
        ("/operator/intervention", "std_msgs/msg/Bool", START_NS + round(t * 1e9) + 1, {"data": bool(active)})
        for t, active in zip(drive.time_s.tolist(), flag(drive), strict=True)
    ]
    path = write("mcap", sorted([*odometry_entries(drive), *flags], key=lambda entry: entry[2]), "run")
    as_recorded = RobotConfig(intervention=InterventionFlag(inverted=False))  # ingest would turn or drop the odd ones
    assert not ingested([path], out, robot=as_recorded).quarantined
    listed = out.parent / "events.csv"
    listed.write_text(f"bag,start,end,outcome,reason\n{events}")
    label_dataset(out, LabelConfig(), listed if events else None)
    return [(x.severity, x.message) for x in check_dataset(out).findings if x.check == "labels"]


def test_a_flag_that_is_true_where_the_robot_is_free(write_recording: Write, tmp_path: Path) -> None:
    found = judged(write_recording, tmp_path / "out", lambda drive: drive.values[:, 7] > 0)
    assert (Severity.FAIL, True) in [
        (kind, "nearly all of the time in which it drives" in text) for kind, text in found
    ]
    assert any("of all rows are 'intervention'" in text and "flag's meaning" in text for _, text in found)


def test_a_flag_that_is_true_always(write_recording: Write, tmp_path: Path) -> None:
    found = judged(write_recording, tmp_path / "out", lambda drive: np.ones(len(drive.time_s)))
    assert any(kind is Severity.FAIL and text.startswith("100% of it failed") for kind, text in found)


def test_a_flag_that_is_true_where_it_stands(write_recording: Write, tmp_path: Path) -> None:
    found = judged(write_recording, tmp_path / "out", lambda drive: drive.values[:, 7] == 0)
    assert any(kind is Severity.WARN and "in which it stands, and no other" in text for kind, text in found)
    assert not any(kind is Severity.FAIL for kind, _ in found)


def test_a_few_interventions_are_believed(write_recording: Write, tmp_path: Path) -> None:
    assert judged(write_recording, tmp_path / "out", lambda drive: (drive.time_s > 20) & (drive.time_s < 24)) == []


@pytest.mark.parametrize("end_s", [35, 58])
def test_what_a_person_says_is_warned_of_and_no_more(write_recording: Write, tmp_path: Path, end_s: int) -> None:
    events = f"run,0,{end_s},0,mud\n"
    found = judged(write_recording, tmp_path / "out", lambda drive: np.zeros(len(drive.time_s)), events)
    assert {kind for kind, _ in found} == {Severity.WARN}
    assert any("failed, mostly by 'mud': look at the events file" in text for _, text in found)
