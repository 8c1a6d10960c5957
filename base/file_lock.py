"""A lock that the kernel releases with the process that holds it, however that ends."""

import fcntl
import os
from pathlib import Path
from typing import IO


def take_lock(path: Path) -> IO[str]:
    """The lock file at a path, made where it is not there and held until it is closed; waits for nobody.

    Raises:
        BlockingIOError: Another process holds it.
        OSError: It cannot be opened.
    """
    while True:
        lock = path.open("a")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if _is_there(path, lock):
                return lock
        except BaseException:
            lock.close()
            raise
        lock.close()


def _is_there(path: Path, lock: IO[str]) -> bool:
    """Whether the file is still the one at the path: who held it before may have removed it."""
    try:
        return os.path.samestat(os.fstat(lock.fileno()), path.stat())
    except FileNotFoundError:
        return False
