"""A data set with any file damaged: the check ends with findings, and nothing that is cut off passes it."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from damage import PASSED, in_limits, judged

from navtool.base.errors import DatasetsError
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig

TIMES = [1, pytest.param(12, marks=pytest.mark.slow)]


@pytest.fixture
def sound(write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path) -> Path:
    """Two short episodes."""
    paths = [write_recording("mcap", drive_entries(1.0, seed=number), f"run-{number}") for number in range(2)]
    out = tmp_path / "sound"
    ingest(paths, out, RobotConfig(), IngestConfig())
    return out


def files_of(root: Path) -> list[str]:
    """The files that count, by their paths within the data set."""
    found = [path.relative_to(root).as_posix() for path in sorted(root.rglob("*")) if path.is_file()]
    return [name for name in found if not name.endswith((".svg", "lock"))]


@pytest.mark.parametrize("times", TIMES)
def test_no_damage_ends_in_anything_but_findings(times: int, sound: Path, tmp_path: Path) -> None:
    files = files_of(sound)
    assert len(files) > 20
    calls = [(sound, file, seed, tmp_path) for file in files for seed in range(times)]
    told = [judged(*call) for call in calls] if times == 1 else in_limits(judged, calls)
    assert all(told)
    assert not any("Memory" in outcome for outcome in told)
    assert told.count(PASSED) < len(told) / 2


@pytest.mark.slow
def test_no_file_that_is_cut_off_passes(sound: Path) -> None:
    for file in files_of(sound):
        whole = (sound / file).read_bytes()
        for share in (0.0, 0.6, 0.99):
            (sound / file).write_bytes(whole[: int(len(whole) * share)])
            if share == 0.99 and file.endswith(".json"):
                (sound / file).write_bytes(whole.rstrip()[:-1])
            assert not _passes(sound), (file, share)
        (sound / file).write_bytes(whole)
    assert check_dataset(sound).passed


def _passes(root: Path) -> bool:
    try:
        return check_dataset(root).passed
    except DatasetsError:
        return False
