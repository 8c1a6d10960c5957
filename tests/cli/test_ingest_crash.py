"""Ingest is killed at any moment, or runs out of disk: what was reported stays, and resuming gives the same bytes."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from disk_factory import SmallDisk
from hashes import hashes

from navtool.datasets.check import check_dataset
from navtool.datasets.store.reader import NavDataset

NAVTOOL = str(Path(sys.executable).with_name("navtool"))
KILLS = 20


@pytest.fixture
def bags(recording_writer: Callable[..., Path], drive_entries: Callable[..., Any], tmp_path: Path) -> list[str]:
    folder = tmp_path / "bags"
    folder.mkdir()
    return [str(recording_writer(folder, "mcap", drive_entries(20.0, seed=n), f"run-{n}")) for n in range(4)]


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_twenty_kills_and_a_resume_give_the_bytes_of_an_undisturbed_run(
    bags: list[str], tmp_path: Path, workers: str
) -> None:
    whole, out = tmp_path / "whole", tmp_path / "out"
    command = [NAVTOOL, "ingest", *bags, "--workers", workers, "--out"]
    started = time.monotonic()
    subprocess.run([*command, str(whole)], check=True, capture_output=True)  # noqa: S603
    lasted = time.monotonic() - started
    moments = random.Random(0)  # noqa: S311 - no secret
    reported = 0
    for _ in range(KILLS):
        with subprocess.Popen(  # noqa: S603
            [*command, str(out)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True
        ) as process:
            time.sleep(moments.uniform(0.2, 1.0) * lasted)
            os.killpg(process.pid, signal.SIGKILL)
            process.wait(timeout=30)
        if (out / "meta" / "info.json").is_file():
            episodes = len(NavDataset(out).episodes)
            assert episodes >= reported, "an episode that was there is there"
            reported = episodes
    subprocess.run([*command, str(out)], check=True, capture_output=True)  # noqa: S603
    assert hashes(out) == hashes(whole)


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_full_disk_is_one_clear_error_and_earlier_episodes_stay(
    bags: list[str], small_disk: Callable[[int], SmallDisk], workers: str
) -> None:
    out = small_disk(12).place / "out"  # enough for a recording of 20 s, not for four
    first = subprocess.run([NAVTOOL, "ingest", bags[0], "--out", str(out)], capture_output=True, text=True, check=False)  # noqa: S603
    assert first.returncode == 0, first.stderr
    before = hashes(out)
    command = [NAVTOOL, "ingest", *bags, "--workers", workers, "--out", str(out)]
    full = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    assert full.returncode == 1
    assert "No space left on device" in full.stderr
    assert "Traceback" not in full.stderr
    episodes = len(NavDataset(out).episodes)
    assert 1 <= episodes < 4
    assert check_dataset(out).passed
    assert not (out / "navtool" / "staging").exists()
    after = hashes(out)
    kept = ("data/chunk-000/file-000.parquet", "navtool/episodes/episode-000000/provenance.json")
    assert all(after[name] == before[name] for name in kept)


@pytest.mark.slow
def test_two_processes_on_one_output(bags: list[str], tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [NAVTOOL, "ingest", *bags, "--out", str(out), "--json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as first:  # noqa: S603
        while first.poll() is None and not (out / "navtool" / "lock").exists():
            time.sleep(0.01)
        second = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
        told, _ = first.communicate(timeout=120)
    assert second.returncode == 1
    assert "another process is writing to it" in second.stderr
    assert json.loads(told)["episodes"] == 4
