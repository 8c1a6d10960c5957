"""Damaged copies of recordings, read and ingested by processes that may neither hang nor fill the memory."""

import os
import resource
import shutil
import signal
import sqlite3
import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.check import Severity, check_dataset
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.ingest import ingest
from navtool.datasets.recording import open_recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.reader import NavDataset

MEMORY_BYTES = 2 << 30
TIME_S = 60
LENGTHS = (0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 40, (1 << 64) - 1)
EPISODE = "an episode"
PASSED = "passed"


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """One kind of damage, somewhere."""
    changed = bytearray(data)
    offset, size = int(rng.integers(len(data))), int(rng.integers(1, max(len(data) // 8, 2)))
    match int(rng.integers(6)):
        case 0:
            for _ in range(int(rng.integers(1, 20))):
                changed[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        case 1:
            del changed[offset:]
        case 2:
            other = int(rng.integers(len(data)))
            changed[offset : offset + size], changed[other : other + size] = (
                changed[other : other + size],
                changed[offset : offset + size],
            )
        case 3:
            width = int(rng.choice([4, 8]))
            length = LENGTHS[int(rng.integers(len(LENGTHS)))] % (1 << 8 * width)
            changed[offset : offset + width] = length.to_bytes(width, "little")
        case 4:
            changed[offset : offset + size] = bytes(size)
        case _:
            changed[offset:offset] = changed[offset : offset + size]
    return bytes(changed)


def copies(file: Path, folder: Path, number: int) -> Iterator[Path]:
    """Damaged copies of a file, the same ones each time."""
    data = file.read_bytes()
    rng = np.random.default_rng(len(data))
    for index in range(number):
        path = folder / f"{index}{''.join(file.suffixes)}"
        path.write_bytes(damaged(data, rng))
        yield path


def read(path: Path) -> str:
    """Everything that can be asked of a recording: the number of messages, or why there are none."""
    try:
        with open_recording(path) as recording:
            count = 0
            for raw in recording.messages({topic.name for topic in recording.topics}):
                count += 1
                for ask in (recording.header_stamp_ns, recording.decode):
                    try:
                        ask(raw)
                    except DatasetsError:
                        continue
            return str(count)
    except DatasetsError as error:
        return f"refused: {error.what}"


def ingested(path: Path, sound: Path | None = None) -> str:
    """What ingest says of a recording: `EPISODE`, or why there is none; whatever data set there is passes the check.

    Args:
        sound: A data set to whose copy the recording is added; None makes a new one.
    """
    out = path.with_name(f"{path.name}.out")
    before = 0
    if sound is not None:
        shutil.copytree(sound, out)
        before = len(NavDataset(out).episodes)
    report = ingest([path], out, RobotConfig(), IngestConfig(), allow_missing=True)
    if len(report.episodes) + len(report.skipped) + len(report.quarantined) != 1:
        raise AssertionError(f"{path}: neither an episode nor a reason")
    if out.exists() != bool(before or report.episodes):
        raise AssertionError(f"{path}: {out} is {'left' if out.exists() else 'gone'}")
    if out.exists():
        failed = [finding for finding in check_dataset(out).findings if finding.severity is Severity.FAIL]
        episodes = len(NavDataset(out).episodes)
        if failed or episodes != before + len(report.episodes):
            raise AssertionError(f"{path}: {episodes} episodes, {failed}")
        shutil.rmtree(out)
    return report.quarantined[0].reason if report.quarantined else EPISODE


def limit_process() -> None:
    """Two gibibytes beyond what importing takes, and no warnings."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY_BYTES, used + MEMORY_BYTES))
    warnings.simplefilter("error")


def within_time[**P, T](function: Callable[P, T], *arguments: P.args, **options: P.kwargs) -> T:
    """The function's result; the process is ended where that takes too long, even outside of the interpreter."""
    signal.alarm(TIME_S)
    try:
        return function(*arguments, **options)
    finally:
        signal.alarm(0)


def in_limits(function: Callable[..., str], calls: Sequence[tuple[object, ...]], processes: int = 2) -> list[str]:
    """The results of a function of this file, called in processes of limited time and memory."""
    with ProcessPoolExecutor(processes, get_context("spawn"), initializer=limit_process) as pool:
        futures = [pool.submit(within_time, function, *arguments) for arguments in calls]
        try:
            return [future.result() for future in futures]
        except BrokenProcessPool as error:
            begun = [
                call for call, future in zip(calls, futures, strict=True) if not future.done() or future.exception()
            ]
            raise AssertionError(f"a process crashed or took more than {TIME_S} s, at one of {begun[:3]}") from error


def judged(sound: Path, file: str, seed: int, folder: Path) -> str:
    """What the check says of a copy of a data set with one damaged file: ``passed``, or what it finds first.

    Args:
        file: Its path within the data set.
        folder: Where the copy is made.
    """
    root = folder / f"{seed}-{file.replace('/', '-')}"
    shutil.copytree(sound, root)
    data = (root / file).read_bytes()
    (root / file).write_bytes(damaged(data, np.random.default_rng(seed)))
    try:
        failed = [finding for finding in check_dataset(root).findings if finding.severity is Severity.FAIL]
    except DatasetsError as error:
        return f"refused: {error.what}"
    finally:
        shutil.rmtree(root)
    return f"{failed[0].check}: {failed[0].message}" if failed else PASSED


SPECIAL = (0, 1, (1 << 31) - 1, (1 << 32) - 1, (1 << 63) - 1, (1 << 64) - 1, 0x7FF0 << 48, 0x7FF8 << 48, 0x7FEF << 48)
"""Lengths and numbers at the ends of their ranges; the last three are infinity, NaN and almost the largest double."""


def damage_messages(database: sqlite3.Connection, rng: np.random.Generator) -> None:
    """Change one message, some or all of one topic, or of several."""
    topics = [key for (key,) in database.execute("SELECT id FROM topics ORDER BY id")]
    for topic in rng.choice(topics, int(rng.integers(1, 4)), replace=False).tolist():
        query = "SELECT id, timestamp, data FROM messages WHERE topic_id = ? ORDER BY id"
        messages = database.execute(query, (topic,)).fetchall()
        share = rng.choice([0.0, 0.3, 1.0])
        chosen = [row for row in messages if rng.random() < share] or [messages[int(rng.integers(len(messages)))]]
        kind, place, bit = int(rng.integers(4)), rng.random(), int(rng.integers(63))
        special, width = int(SPECIAL[int(rng.integers(len(SPECIAL)))]), int(rng.choice([4, 8]))
        for key, time, data in chosen:
            changed = bytearray(data)
            at = 4 + int(place * (min(len(data), 100) if bit % 2 else len(data))) // width * width
            match kind:
                case 0:
                    time ^= 1 << bit  # noqa: PLW2901 - as recorded but for this
                case 1:
                    changed[at : at + width] = (special % (1 << 8 * width)).to_bytes(width, "little")
                case 2:
                    del changed[at:]
                case _:
                    changed = bytearray(damaged(data, rng))
            update = "UPDATE messages SET timestamp = ?, data = ? WHERE id = ?"
            database.execute(update, (time, bytes(changed), key))
