"""Each kind of damage is found, named with its place, and nothing else is."""

import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from counted import Counted
from dataset_damage import DAMAGE

from navtool.datasets.check import CheckReport, Severity, check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.labels.apply import label_dataset
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.robot.config import RobotConfig


@pytest.fixture
def dataset(labelled_dataset: Path, tmp_path: Path) -> Path:
    """A copy to damage; sound before."""
    return Path(shutil.copytree(labelled_dataset, tmp_path / "dataset"))


def _findings(report: CheckReport) -> set[tuple[str, str]]:
    return {(finding.severity.name, finding.check) for finding in report.findings}


ALWAYS = {("WARN", "leakage"), ("WARN", "labels")}
"""The drives of the tests are all of one moment, so that their times overlap, and a third of each is a collision."""


def test_a_sound_data_set_has_nothing_but_what_it_says_of_itself(labelled_dataset: Path) -> None:
    progress = Counted()
    report = check_dataset(labelled_dataset, progress=progress)
    assert progress.adds_up()
    assert [name for _, name in progress.finished] == report.checks
    assert report.passed
    assert _findings(report) == ALWAYS
    assert all(
        "of the same time as" in finding.message or "of all rows are 'collision'" in finding.message
        for finding in report.findings
    )
    told = report.to_json()
    assert set(told) == {"passed", "dataset", "episodes", "rows", "checks", "findings", "splits"}
    assert told["checks"] == report.checks
    assert len(report.checks) == 12


@pytest.mark.parametrize("name", DAMAGE)
def test_damage_is_found_and_named(name: str, dataset: Path) -> None:
    damage, expected, message = DAMAGE[name]
    damage(dataset)
    report = check_dataset(dataset)
    found = [
        finding
        for finding in report.findings
        if (finding.severity.name, finding.check) == expected and re.search(message, finding.message)
    ]
    assert found, [(f.severity.name, f.check, f.where, f.message) for f in report.findings]
    assert all(finding.where for finding in found)
    assert report.passed == (expected[0] == "WARN")
    # A file that cannot be read hides from the checks behind it what they look for in it.
    if expected[1] not in ("files", "metadata", "video") and name != "the same time within another":
        assert _findings(report) - ALWAYS - {expected} <= {("WARN", "streams"), ("WARN", "labels"), ("WARN", "splits")}


def test_a_frozen_camera_and_a_frozen_lidar(
    write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    first: dict[str, Any] = {}
    entries = []
    for topic, kind, at, fields in drive_entries(8.0):
        if topic in ("/points", "/camera/image_raw/compressed"):
            first.setdefault(topic, fields)
            fields = first[topic] | {"header": fields["header"]}  # noqa: PLW2901 - the old content, a new stamp
        entries.append((topic, kind, at, fields))
    ingest([write_recording("mcap", entries)], tmp_path / "out", RobotConfig(), IngestConfig())
    label_dataset(tmp_path / "out", LabelConfig())
    report = check_dataset(tmp_path / "out")
    told = {finding.check: finding.message for finding in report.findings if finding.severity is Severity.WARN}
    assert told["video"] == "every frame looks the same"
    # The points that stay are drawn anew from each cloud's stamp: here all of them fit.
    assert told["clouds"].startswith("the cloud is frozen for 7")


@pytest.mark.parametrize(
    "part", ["data/chunk-000/file-000.parquet", "clouds/part-00000.parquet", "streams/imu.parquet", ".mp4"]
)
def test_a_flipped_bit_is_found(part: str, labelled_dataset: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    shutil.copytree(labelled_dataset, out)
    path = next(file for file in sorted(out.rglob("*")) if file.as_posix().endswith(part))
    content = bytearray(path.read_bytes())
    for share in (0.3, 0.5, 0.7):
        content[int(len(content) * share)] ^= 4
    path.write_bytes(content)
    report = check_dataset(out)
    assert not report.passed
    assert any(finding.severity is Severity.FAIL and finding.where for finding in report.findings)
