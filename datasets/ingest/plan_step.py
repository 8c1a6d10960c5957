"""First step from a recording to an episode: it is hashed and planned."""

import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from navtool.base.meter import Meter
from navtool.base.note import Note
from navtool.base.workers import Stopped
from navtool.datasets.ingest.config import IngestConfig, Merge
from navtool.datasets.ingest.contents import streams_left_out
from navtool.datasets.ingest.output_errors import output_errors
from navtool.datasets.ingest.plan import EpisodePlan, plan_episode
from navtool.datasets.ingest.work import HASH_SHARE
from navtool.datasets.recording import Recording, open_recording
from navtool.datasets.recording.changed import changed_meanwhile
from navtool.datasets.recording.identity import recording_sha256, recording_state
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.schema import Contents
from navtool.datasets.store.staged_episode import streams_folder


@dataclass(frozen=True, slots=True)
class Known:
    """The content hash of a recording that needs no work."""

    sha256: str


@dataclass(frozen=True, slots=True)
class Planned:
    """A recording's content hash, its size in bytes, and the plan of its episode."""

    sha256: str
    size: int
    plan: EpisodePlan


def plan_step(
    path: Path,
    robot: RobotConfig,
    config: IngestConfig,
    fixed: Contents | None,
    known: frozenset[str],
    staged: Path | None,
    meter: Meter,
) -> Planned | Known:
    """Hash a recording and, unless it is known, read it once and write its small streams.

    Args:
        known: Content hashes of the recordings that need no work.
        staged: The episode's staged folder; None writes nothing.

    Raises:
        DatasetsError: The recording gives no episode, or is still being written.
    """
    before = recording_state(path)
    on_hashed = _hash_counter(meter, sum(size for _, size, _ in before))
    with _thread_beside(on_hashed) as (thread, on_hashed_there):
        # Where nothing is known yet the recording is hashed while it is read: hashing needs no interpreter.
        hashing = thread.submit(recording_sha256, path, on_hashed_there)
        if known and hashing.result()[0] in known:
            meter.spare()
            return Known(hashing.result()[0])
        with output_errors(staged), open_recording(path, merged=config.merge is Merge.folder) as recording:
            streams_to = None if staged is None else streams_folder(staged)
            on_read = meter.part(recording.start_ns, recording.end_ns, 1 - HASH_SHARE)
            plan = plan_episode(recording, robot, config, fixed, streams_to, on_read)
            plan.notes = [*_merged_notes(recording, config), *plan.notes, *_contents_notes(fixed, plan.found)]
        sha256, size = hashing.result()
    if recording_state(path) != before:
        # The hash would be that of other bytes than were read, and the rest would never be read.
        raise changed_meanwhile(path)
    return Planned(sha256, size, plan)


def _merged_notes(recording: Recording, config: IngestConfig) -> list[Note]:
    if config.merge is not Merge.folder or len(recording.files) < 2:
        return []
    names = ", ".join(file.name for file in recording.files)
    return [Note("recording.merged", f"made of {len(recording.files)} files: {names}")]


def _contents_notes(fixed: Contents | None, found: Contents) -> list[Note]:
    extra = [] if fixed is None else streams_left_out(fixed, found)
    if not extra:
        return []
    what = f"{', '.join(extra)}: not in the rows, since the data set's first recording did not have them"
    return [Note("contents.left-out", what)]


def _hash_counter(meter: Meter, size_bytes: int) -> Callable[[int], None]:
    """What to call with the bytes of each piece of a recording that was hashed."""
    on_reached, done = meter.part(0, size_bytes, HASH_SHARE), 0

    def on_hashed(read_bytes: int) -> None:
        nonlocal done
        done += read_bytes
        on_reached(done)

    return on_hashed


@contextmanager
def _thread_beside(
    on_hashed: Callable[[int], None],
) -> Iterator[tuple[ThreadPoolExecutor, Callable[[int], None]]]:
    """A thread, and the callback for its work, by which it ends soon where this one fails or is interrupted."""
    given_up = threading.Event()

    def on_hashed_there(read_bytes: int) -> None:
        if given_up.is_set():
            raise Stopped
        on_hashed(read_bytes)

    with ThreadPoolExecutor(1) as thread:
        try:
            yield thread, on_hashed_there
        except BaseException:
            given_up.set()
            raise
