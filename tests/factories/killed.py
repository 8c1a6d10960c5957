"""Ingest killed before each of the calls by which it changes the disk, one after the other."""

import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from hashes import hashes

from navtool.base.files import read_json
from navtool.datasets.check import check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.reader import NavDataset

CALLS = ("replace", "rename", "fsync", "unlink", "rmdir")
KILLED = 9


def kill_at_every_call(before: Path | None, paths: Sequence[Path], folder: Path) -> tuple[int, list[str]]:
    """Ingest recordings into copies of a data set, each time killed one call later, and then undisturbed.

    To be called in a process without threads: it forks.

    Args:
        before: The data set; None for none.

    Returns:
        The number of calls, and what was not as it should be: a data set that was damaged after the kill, or whose
        bytes were others in the end than without one.
    """
    whole, complaints = folder / "whole", []
    _copy(before, whole)
    _in_a_child(lambda: _ingest(paths, whole))
    wanted = hashes(whole)
    calls = 0
    while True:
        out = folder / f"killed-{calls}"
        _copy(before, out)
        finished = _in_a_child(lambda: _ingest(paths, out, calls)) == 0  # noqa: B023 - called at once
        if _in_a_child(lambda: _look(out)):  # noqa: B023
            complaints.append(f"damaged when killed before call {calls}")
        if _in_a_child(lambda: _ingest(paths, out)) or hashes(out) != wanted:  # noqa: B023
            complaints.append(f"other bytes after a kill before call {calls}")
        shutil.rmtree(out)
        if finished:
            return calls, complaints
        calls += 1


def _copy(before: Path | None, out: Path) -> None:
    if before is not None:
        shutil.copytree(before, out)


def _in_a_child(function: Callable[[], object]) -> int:
    child = os.fork()
    if child == 0:
        code = 1
        try:
            function()
            code = 0
        finally:
            os._exit(code)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _ingest(paths: Sequence[Path], out: Path, survived: int | None = None) -> None:
    """Ingest; a process that survives a number of calls only ends before the next."""
    left = survived

    def counted(call: Callable[..., Any]) -> Callable[..., Any]:
        def count(*arguments: Any, **options: Any) -> Any:
            nonlocal left
            if left is not None:
                if left == 0:
                    os._exit(KILLED)
                left -= 1
            return call(*arguments, **options)

        return count

    for name in CALLS:
        setattr(os, name, counted(getattr(os, name)))
    report = ingest(paths, out, RobotConfig(), IngestConfig())
    if report.quarantined:
        raise ValueError(f"unexpected: {report.quarantined}")


def _look(out: Path) -> None:
    """As a reader looks at it: everything passes, and the statistics count the rows that are there."""
    if not Layout(out).info.is_file():
        return
    if not Layout(out).description.is_file() and not (Layout(out).beside / "journal.json").is_file():
        raise ValueError("a LeRobot data set that we cannot read")
    rows = len(NavDataset(out))
    stats: dict[str, Any] = read_json(Layout(out).stats, "")
    if stats["index"]["count"] != [rows] or not check_dataset(out).passed:
        raise ValueError("damaged")
