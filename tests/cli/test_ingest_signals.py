"""Ingest is interrupted, or one of its processes killed: one clear line, no process and nothing half written stays."""

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hashes import hashes

from navtool.datasets.check import check_dataset

NAVTOOL = str(Path(sys.executable).with_name("navtool"))
INTERRUPTS = 4
PATIENCE_S = 20.0


@pytest.fixture
def bags(write_recording: Callable[..., Path], drive_entries: Callable[..., Any]) -> list[str]:
    return [str(write_recording("mcap", drive_entries(12.0, seed=number), f"run-{number}")) for number in range(3)]


@pytest.fixture
def heeded_interrupts() -> Iterator[None]:
    """A shell's background job ignores SIGINT, and so would the programs that it starts."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def begun(command: list[str]) -> "subprocess.Popen[str]":
    """A command in a session of its own."""
    return subprocess.Popen(  # noqa: S603
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def processes_of(session: int) -> dict[int, str]:
    """The living processes of a session and their command lines."""
    found = {}
    for entry in Path("/proc").iterdir():
        try:
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            line = (entry / "cmdline").read_text().replace("\0", " ")
        except (OSError, IndexError):
            continue
        if int(fields[3]) == session and fields[0] not in "ZX":
            found[int(entry.name)] = line
    return found


def workers_of(session: int) -> list[int]:
    """The processes that read recordings."""
    return [pid for pid, line in processes_of(session).items() if "spawn_main" in line]


def assert_none_stays(session: int) -> None:
    """All processes of a session end within a while."""
    patience = time.monotonic() + PATIENCE_S
    while processes_of(session):
        assert time.monotonic() < patience, processes_of(session)
        time.sleep(0.05)


def wait_until(true: Callable[[], object], process: "subprocess.Popen[str]") -> None:
    while not true():
        assert process.poll() is None, process.communicate()
        time.sleep(0.005)


def assert_nothing_half_written(out: Path, command: list[str], whole: Path) -> None:
    """The data set passes the check, and the same command gives the bytes of an undisturbed one."""
    if out.exists():
        assert not (out / "navtool" / "staging").exists()
        assert check_dataset(out).passed
    subprocess.run(command, capture_output=True, check=True)  # noqa: S603
    assert hashes(out) == hashes(whole)


@pytest.fixture
def whole(bags: list[str], tmp_path: Path) -> Path:
    """The data set of an undisturbed ingest."""
    command = [NAVTOOL, "ingest", *bags, "--out", str(tmp_path / "whole")]
    subprocess.run(command, capture_output=True, check=True)  # noqa: S603
    return tmp_path / "whole"


@pytest.mark.slow
@pytest.mark.usefixtures("heeded_interrupts")
@pytest.mark.parametrize("to", ["the process", "its group, as a terminal does"])
@pytest.mark.parametrize("workers", ["1", "2"])
def test_an_interrupt_at_any_moment_ends_in_one_line(
    workers: str, to: str, bags: list[str], whole: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out"
    command = [NAVTOOL, "ingest", *bags, "--workers", workers, "--out", str(out)]
    moments = random.Random(0)  # noqa: S311 - no secret
    ended = 0
    for number in range(INTERRUPTS):
        with begun(command) as process:
            while process.poll() is None and not (out / "navtool" / "staging").exists():
                time.sleep(0.005)
            time.sleep(0.0 if number == 0 else moments.uniform(0.0, 3.0))
            interrupted = process.poll() is None
            if interrupted:
                (os.kill if to == "the process" else os.killpg)(process.pid, signal.SIGINT)
            _, said = process.communicate(timeout=60)
        assert_none_stays(process.pid)
        if interrupted and process.returncode != 0:
            assert process.returncode == 130
            (line,) = [line for line in said.splitlines() if line.strip()]
            assert line.startswith("error: interrupted;")
            ended += 1
        assert not (out / "navtool" / "staging").exists()
    assert ended, "the first one is sent as soon as an episode is begun"
    assert_nothing_half_written(out, command, whole)


@pytest.mark.slow
def test_a_killed_worker_is_one_clear_error(bags: list[str], whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [NAVTOOL, "ingest", *bags, "--workers", "2", "--out", str(out)]
    with begun(command) as process:
        wait_until(lambda: (out / "navtool" / "staging").exists() and workers_of(process.pid), process)
        os.kill(workers_of(process.pid)[0], signal.SIGKILL)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 1
    error, cure = [line for line in said.splitlines() if line.strip()]
    assert error.startswith("error: a worker process was ended from outside")
    assert "run the command again" in cure
    assert_none_stays(process.pid)
    assert_nothing_half_written(out, command, whole)


@pytest.mark.slow
def test_a_killed_command_takes_its_workers_with_it(bags: list[str], whole: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = [NAVTOOL, "ingest", *bags, "--workers", "2", "--out", str(out)]
    with begun(command) as process:
        wait_until(lambda: (out / "navtool" / "staging").exists() and workers_of(process.pid), process)
        process.kill()
        process.communicate(timeout=60)
    assert_none_stays(process.pid)
    subprocess.run(command, capture_output=True, check=True)  # noqa: S603
    assert hashes(out) == hashes(whole)
