"""Damaged copies of small recordings, ingested by processes with limits on memory and time.

Each becomes an episode that passes every check, or is quarantined with its reason, and nothing else.
"""

import shutil
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest
from damage import copies, limit_memory

from navtool.datasets.check import Severity, check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot import RobotConfig

CONTAINERS = ("ros1_bz2", "ros1_lz4", "db3", "mcap_zstd", "mcap_lz4")
TIME_S = 60.0


def outcome(path: str) -> tuple[str, float]:
    """What became of a copy, and the seconds it took."""
    started = time.monotonic()
    out = Path(path).with_suffix(".out")
    report = ingest([Path(path)], out, RobotConfig(), IngestConfig())
    if report.quarantined:
        assert not report.episodes
        assert not out.exists(), "nothing is left of a data set without episodes"
        told = f"quarantined: {report.quarantined[0].reason}"
        assert report.quarantined[0].reason.strip()
    else:
        failed = [x for x in check_dataset(out).findings if x.severity is Severity.FAIL]
        assert failed == []
        told = f"{report.rows} rows"
        shutil.rmtree(out)
    return told, time.monotonic() - started


@pytest.mark.parametrize("number", [6, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("container", CONTAINERS)
def test_damage_gives_a_sound_episode_or_a_named_reason(
    container: str, number: int, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    path = write_recording(container, drive_entries(1.0, ros1=container.startswith("ros1")))
    file = path if path.is_file() else next(x for x in path.iterdir() if x.name != "metadata.yaml")
    whole, _ = outcome(str(file))
    assert whole == "10 rows"
    folder = tmp_path / "copies"
    folder.mkdir()
    paths = [str(copy) for copy in copies(file, folder, number)]
    if number == 6:
        outcomes = [outcome(copy) for copy in paths]
    else:
        with ProcessPoolExecutor(2, get_context("fork"), initializer=limit_memory) as pool:
            outcomes = list(pool.map(outcome, paths, timeout=number * TIME_S))
    assert max(seconds for _, seconds in outcomes) < TIME_S
    assert any(told != whole for told, _ in outcomes) or number == 6, "the damage does something"
