"""Damaged copies of small recordings through all of ingest: an episode that passes the check, or a named reason."""

import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from damage import EPISODE, copies, damage_messages, in_limits, ingested

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig

CHUNKED = {"ros1_bz2": "ros1_bz2", "ros1_lz4": "ros1_lz4", "mcap_zstd": "mcap_small_chunks", "mcap_lz4": "mcap_lz4"}
"""By container and compression, what the factory calls them; as its writers let the size of chunks be chosen."""
CHUNK_BYTES = 1 << 14
STREAMS = ("camera", "lidar", "odometry", "imu", "joints", "tf")
NUMBERS = [6, pytest.param(300, marks=pytest.mark.slow)]


@pytest.fixture
def bag(
    recording_writer: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> Callable[..., Path]:
    """``bag(kind) -> Path`` of the file of a drive of one second."""

    def make(kind: str) -> Path:
        entries = drive_entries(1.0, ros1=kind.startswith("ros1"), streams=STREAMS)
        if kind in CHUNKED:
            return recording_writer(tmp_path, CHUNKED[kind], entries, chunk_bytes=CHUNK_BYTES)
        return next(recording_writer(tmp_path, kind, entries).glob("*.db3"))

    return make


def told_of(paths: list[Path], sound: Path) -> list[str]:
    """What ingest says of each copy; every third is added to a data set, the others begin one."""
    report = ingest([sound], sound.with_name("sound"), RobotConfig(), IngestConfig())
    assert report.episodes
    calls = [(path, sound.with_name("sound") if number % 3 == 0 else None) for number, path in enumerate(paths)]
    return [ingested(*call) for call in calls] if len(calls) < 20 else in_limits(ingested, calls)


def assert_reasons(told: list[str]) -> None:
    """Both outcomes come, and every reason says what is wrong with the recording."""
    assert EPISODE in told
    assert any(outcome != EPISODE for outcome in told) or len(told) < 20
    assert all(told)
    assert not any("Memory" in outcome or "memory" in outcome for outcome in told), told


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("kind", [*CHUNKED, "db3"])
def test_a_damaged_recording_is_an_episode_or_has_a_reason(
    kind: str, number: int, bag: Callable[..., Path], tmp_path: Path
) -> None:
    file = bag(kind)
    folder = tmp_path / "copies"
    folder.mkdir()
    assert_reasons(told_of(list(copies(file, folder, number)), file))


@pytest.mark.parametrize("number", NUMBERS)
def test_a_recording_of_damaged_messages_is_an_episode_or_has_a_reason(
    number: int, bag: Callable[..., Path], tmp_path: Path
) -> None:
    """The container is sound: all damage reaches the decoders and what comes behind them."""
    file = bag("db3")
    folder = tmp_path / "copies"
    folder.mkdir()
    rng = np.random.default_rng(0)
    paths = [folder / f"{index}.db3" for index in range(number)]
    for path in paths:
        path.write_bytes(file.read_bytes())
        with sqlite3.connect(path) as database:
            damage_messages(database, rng)
        database.close()
    assert_reasons(told_of(paths, file))
