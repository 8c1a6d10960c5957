"""Damaged copies of small recordings, read by processes that may neither hang nor fill the memory nor raise anything
but a `DatasetsError`."""

import shutil
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest
from damage import copies, limit_memory

from navtool.datasets.errors import DatasetsError
from navtool.datasets.recording import open_recording

CONTAINERS = ("ros1", "ros1_bz2", "ros1_lz4", "db3", "mcap", "mcap_zstd", "mcap_lz4", "mcap_small_chunks")
TIME_S = 20.0


def read(path: str) -> tuple[str, float]:
    """Everything that can be asked of a recording: the number of messages or the error, and the seconds it took."""
    started = time.monotonic()
    try:
        with open_recording(Path(path)) as recording:
            count = 0
            for raw in recording.messages({topic.name for topic in recording.topics}):
                count += 1
                for ask in (recording.header_stamp_ns, recording.decode):
                    try:
                        ask(raw)
                    except DatasetsError:
                        continue
            return str(count), time.monotonic() - started
    except DatasetsError as error:
        return f"refused: {error.what}", time.monotonic() - started


@pytest.mark.parametrize("number", [12, pytest.param(300, marks=pytest.mark.slow)])
@pytest.mark.parametrize("container", CONTAINERS)
def test_no_damage_ends_in_anything_but_messages_or_one_clear_error(
    container: str, number: int, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    path = write_recording(container, drive_entries(1.0, ros1=container.startswith("ros1")))
    file = path if path.is_file() else next(x for x in path.iterdir() if x.name != "metadata.yaml")
    whole, _ = read(str(file))
    folder = tmp_path / "copies"
    folder.mkdir()
    paths = [str(copy) for copy in copies(file, folder, number)]
    if number == 12:
        outcomes = [read(copy) for copy in paths]
    else:
        with ProcessPoolExecutor(2, get_context("fork"), initializer=limit_memory) as pool:
            outcomes = list(pool.map(read, paths, timeout=number * TIME_S))
    assert max(seconds for _, seconds in outcomes) < TIME_S
    told = [outcome for outcome, _ in outcomes]
    assert any(outcome not in (whole, "0") for outcome in told), "the damage does something"
    shutil.rmtree(folder)
