"""A lock is held by one at a time, and by nobody once its holder is gone, however that ended."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from navtool.base.file_lock import take_lock

HOLD = """
import sys, time
from pathlib import Path
from navtool.base.file_lock import take_lock
lock = take_lock(Path(sys.argv[1]))
print("held", flush=True)
time.sleep(60)
"""


def test_one_holds_it_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    with take_lock(path), pytest.raises(BlockingIOError):
        take_lock(path)
    take_lock(path).close()


def test_the_kernel_releases_it_with_a_killed_process(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    command = [sys.executable, "-c", HOLD, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE) as process:  # noqa: S603 - our own interpreter and text
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        with pytest.raises(BlockingIOError):
            take_lock(path)
        os.kill(process.pid, signal.SIGKILL)
    take_lock(path).close()


def test_a_lock_whose_file_is_removed_is_another_one(tmp_path: Path) -> None:
    path = tmp_path / "lock"
    with take_lock(path):
        path.unlink()
        with take_lock(path), pytest.raises(BlockingIOError):
            take_lock(path)


def test_a_folder_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        take_lock(tmp_path / "none" / "lock")
