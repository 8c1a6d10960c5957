"""Killed between any two steps of writing, a data set is whole, and resuming gives the bytes of an undisturbed run."""

import shutil
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import pytest
from killed import kill_at_every_call

from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig

STREAMS = ("camera", "odometry", "command")


@pytest.mark.slow
@pytest.mark.parametrize("there", ["nothing", "two episodes"])
def test_a_kill_before_any_call_that_writes(
    there: str, write_recording: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path
) -> None:
    def bag(number: int, seconds: float) -> Path:
        return write_recording("mcap", drive_entries(seconds, seed=number, streams=STREAMS), f"run-{number}-{seconds}")

    before = None
    paths = [bag(0, 1.0), bag(1, 1.0)]
    if there != "nothing":
        before = tmp_path / "before"
        ingest(paths, before, RobotConfig(), IngestConfig())
        shutil.rmtree(paths[0])
        shutil.move(bag(0, 2.0), paths[0])  # replaces its episode, and moves the rows of the other
        paths.append(bag(2, 1.0))
    folder = tmp_path / "killed"
    folder.mkdir()
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        calls, complaints = pool.submit(kill_at_every_call, before, paths, folder).result(timeout=600)
    assert complaints == []
    assert calls > 20
