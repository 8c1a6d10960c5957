"""NaN that a message's definition allows is no finding; other NaN is."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from ingesting import ingested

from navtool.datasets.check import check_dataset


@pytest.mark.parametrize(("unmeasured", "warned"), [("percentage", False), ("voltage", False), ("current", True)])
def test_what_a_battery_never_measures_is_no_finding_but_for_its_current(
    write_recording: Callable[..., Path],
    drive_entries: Callable[..., list[Any]],
    tmp_path: Path,
    unmeasured: str,
    warned: bool,
) -> None:
    entries = drive_entries(1.0)
    for topic, _, _, fields in entries:
        if "battery" in topic:
            fields[unmeasured] = float("nan")
    assert not ingested([write_recording("mcap", entries)], tmp_path / "out").quarantined
    told = [finding.message for finding in check_dataset(tmp_path / "out").findings if finding.check == "native"]
    assert any("NaN as recorded" in message for message in told) is warned, told


def test_what_is_measured_now_and_then_is_told(
    write_recording: Callable[..., Path], drive_entries: Callable[..., list[Any]], tmp_path: Path
) -> None:
    entries = drive_entries(1.0)
    batteries = [fields for topic, _, _, fields in entries if "battery" in topic]
    batteries[0]["percentage"] = float("nan")
    assert not ingested([write_recording("mcap", entries)], tmp_path / "out").quarantined
    told = [finding.message for finding in check_dataset(tmp_path / "out").findings if finding.check == "native"]
    assert any("NaN as recorded: percentage" in message for message in told), told
