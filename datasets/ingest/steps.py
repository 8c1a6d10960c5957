"""The steps from a recording to an episode: plan it, read its segments, join and add them.

Planning and reading may happen in other processes; what they take and return crosses between them.
"""

import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from navtool.base.errors import OutputError
from navtool.base.files import write_bytes, write_json
from navtool.base.lineage import code_version, file_sha256
from navtool.base.meter import Meter
from navtool.base.plain import plain_fields
from navtool.base.workers import Stopped
from navtool.datasets.ingest.config import PARENT, IngestConfig, Merge
from navtool.datasets.ingest.episode import join_segments, renumber
from navtool.datasets.ingest.foreseen import Foreseen
from navtool.datasets.ingest.plan import EpisodePlan, plan_episode
from navtool.datasets.ingest.report import EpisodeSummary
from navtool.datasets.ingest.segment import Segment, SegmentResult
from navtool.datasets.ingest.settings import settings_hash, streams_left_out
from navtool.datasets.ingest.sync_picture import sync_picture
from navtool.datasets.ingest.sync_report import stream_notes
from navtool.datasets.ingest.work import HASH_SHARE
from navtool.datasets.ingest.write_segment import write_segment
from navtool.datasets.recording import open_recording
from navtool.datasets.recording.changed import changed_meanwhile
from navtool.datasets.recording.identity import absolute, recording_sha256, recording_state, source_name
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.store.description import Description
from navtool.datasets.store.schema import Contents, features_of
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering, streams_folder
from navtool.datasets.store.writer import Store


@dataclass(frozen=True, slots=True)
class Planned:
    """A recording's content hash and, unless the data set has it, the plan of its episode."""

    sha256: str
    size: int
    plan: EpisodePlan | None


@dataclass(frozen=True, slots=True)
class Joined:
    """A recording's episode, staged whole, and what is to be said of it."""

    folder: EpisodeFolder
    dropped: dict[str, int]
    notes: list[str]


def plan_step(
    path: Path,
    robot: RobotConfig,
    config: IngestConfig,
    fixed: Contents | None,
    known: frozenset[str],
    staged: Path | None,
    meter: Meter,
) -> Planned:
    """Hash a recording and, unless it is known, read it once and write its small streams.

    Args:
        known: Content hashes of the recordings that need no work.
        staged: The episode's staged folder; None writes nothing.

    Raises:
        DatasetsError: The recording gives no episode, or is still being written.
    """
    before = recording_state(path)
    hashed = _hashed(meter, sum(size for _, size, _ in before))
    with _beside(hashed) as (thread, tell):
        # Where nothing is known yet the recording is hashed while it is read: hashing needs no interpreter.
        hashing = thread.submit(recording_sha256, path, tell)
        if known and hashing.result()[0] in known:
            meter.spare()
            return Planned(*hashing.result(), None)
        with _output_errors(staged), open_recording(path, merged=config.merge is Merge.folder) as recording:
            streams_to = None if staged is None else streams_folder(staged)
            reached = meter.part(recording.start_ns, recording.end_ns, 1 - HASH_SHARE)
            plan = plan_episode(recording, robot, config, fixed, streams_to, reached)
        sha256, size = hashing.result()
    if recording_state(path) != before:
        # The hash would be that of other bytes than were read, and the rest would never be read.
        raise changed_meanwhile(path)
    if config.merge is Merge.folder and len(recording.files) > 1:
        plan.notes.insert(
            0, f"made of {len(recording.files)} files: {', '.join(file.name for file in recording.files)}"
        )
    if fixed is not None and (extra := streams_left_out(fixed, plan.found)):
        plan.notes.append(
            f"{', '.join(extra)}: not in the rows, since the data set's first recording did not have them"
        )
    return Planned(sha256, size, plan)


def segment_step(path: Path, segment: Segment, config: IngestConfig, staged: Path, meter: Meter) -> SegmentResult:
    """Read one segment of a recording and write its part of the episode."""
    merged = config.merge is Merge.folder
    with _output_errors(staged), open_recording(path, merged=merged, verify=not segment.sound) as recording:
        return write_segment(recording, segment, config, staged, meter.part(segment.start_ns, segment.end_ns))


def join_step(
    plan: EpisodePlan,
    segments: Sequence[Segment],
    results: Sequence[SegmentResult],
    numbering: Numbering,
    config: IngestConfig,
    staged: Path,
    meter: Meter,
) -> Joined:
    """Join what was read of a recording into the staged files of an episode, at its likely place in the data set."""
    folder = EpisodeFolder(staged, numbering)
    dropped, notes = dict(plan.dropped), list(plan.notes)
    for result in results:
        for name, count in result.undecodable.items():
            key = f"{name}: cannot be decoded"
            dropped[key] = dropped.get(key, 0) + count
    if nonfinite := sum(result.points_nonfinite for result in results):
        dropped["lidar points: not finite"] = nonfinite
    if left := sum(result.not_deskewed for result in results):
        notes.append(f"lidar: {left} clouds without point times or odometry around them; points stay as measured")
    notes += stream_notes(plan.sync_report)
    with _output_errors(staged):
        join_segments(
            plan, segments, results, features_of(plan.contents), config.fps, folder, meter.part(0, len(segments))
        )
    write_json(folder.beside / "calibration.json", plan.calibration.to_json())
    write_json(folder.beside / "sync.json", plan.sync_report | {"dropped": dropped, "notes": notes})
    write_bytes(folder.beside / "sync.svg", sync_picture(plan.sync_report, plan.columns, config.fps).encode())
    return Joined(folder, dropped, notes)


def add_episode(
    store: Store, path: Path, planned: Planned, joined: Joined, robot: RobotConfig, config: IngestConfig
) -> EpisodeSummary:
    """Make a joined recording an episode of the data set, in the place of an older one of the same recording.

    Raises:
        OutputError: A file cannot be written; the data set is then as it was.
    """
    plan = planned.plan
    if plan is None:
        raise ValueError("a recording without a plan")
    replaced = store.episode_from(source_name(path), planned.sha256, plan.recording_start_ns)
    if replaced is not None:
        joined.notes.append("in the place of an older episode; labels were taken away: run `navtool label` again")
    with _output_errors(joined.folder.root):
        renumber(joined.folder, store.numbering(replaced), plan.contents)
    number = joined.folder.numbering.episode_index
    summary = summary_of(plan, path, number, dropped=joined.dropped, notes=joined.notes, rebuilt=replaced is not None)
    description = _description(plan, robot, config)
    provenance = _provenance(path, planned, summary, plan, robot, config)
    if plan.contents.image:
        provenance["video_sha256"] = file_sha256(joined.folder.video)
    if replaced is None:
        store.commit(joined.folder, description, provenance)
    else:
        store.replace(joined.folder, provenance)
    return summary


def foresee_episode(
    store: Foreseen, path: Path, planned: Planned, robot: RobotConfig, config: IngestConfig
) -> EpisodeSummary:
    """What adding a planned recording would do; nothing is written."""
    plan = planned.plan
    if plan is None:
        raise ValueError("a recording without a plan")
    summary = summary_of(plan, path, None)
    provenance = _provenance(path, planned, summary, plan, robot, config)
    summary.episode, summary.rebuilt = store.foresee(
        _description(plan, robot, config), provenance, int(plan.ticks_ns.size)
    )
    if summary.rebuilt:
        summary.notes.append("would take the place of an older episode, whose labels would be taken away")
    return summary


def _description(plan: EpisodePlan, robot: RobotConfig, config: IngestConfig) -> Description:
    return Description(
        fps=config.fps,
        contents=plan.contents,
        robot=plain_fields(robot),
        ingest=plain_fields(config),
        config_hash=settings_hash(robot, config),
    )


def _provenance(
    path: Path,
    planned: Planned,
    summary: EpisodeSummary,
    plan: EpisodePlan,
    robot: RobotConfig,
    config: IngestConfig,
) -> dict[str, object]:
    return {
        "source": summary.source,
        "sha256": planned.sha256,
        "bytes": planned.size,
        "place": place_of(path, config),
        "recording_start_ns": plan.recording_start_ns,
        "start_ns": int(plan.ticks_ns[0]),
        "end_ns": int(plan.ticks_ns[-1]),
        "recovered": list(plan.faults),
        "topics": summary.topics,
        "not_used": summary.not_used,
        "config_hash": settings_hash(robot, config),
        "code_version": code_version(),
    }


def place_of(path: Path, config: IngestConfig) -> str:
    """Where a recording was made, as the settings say: of its folder's name the one it is reached by."""
    return absolute(path).parent.name if config.place == PARENT else config.place


def summary_of(
    plan: EpisodePlan,
    path: Path,
    episode: int | None,
    *,
    dropped: dict[str, int] | None = None,
    notes: list[str] | None = None,
    rebuilt: bool = False,
) -> EpisodeSummary:
    """The episode as the report shows it; of one that is only planned, what the plan knows."""
    return EpisodeSummary(
        episode=episode,
        source=source_name(path),
        rows=int(plan.ticks_ns.size),
        topics=plan.topics.streams(),
        not_used=[plain_fields(topic) for topic in plan.topics.not_used],
        dropped=plan.dropped if dropped is None else dropped,
        sync=dict(plan.sync_report),
        notes=[*plan.notes, *stream_notes(plan.sync_report)] if notes is None else notes,
        rebuilt=rebuilt,
    )


def _hashed(meter: Meter, size_bytes: int) -> Callable[[int], None]:
    """What to call with the bytes of each piece of a recording that was hashed."""
    reached, done = meter.part(0, size_bytes, HASH_SHARE), 0

    def hashed(read_bytes: int) -> None:
        nonlocal done
        done += read_bytes
        reached(done)

    return hashed


@contextmanager
def _beside(advance: Callable[[int], None]) -> Iterator[tuple[ThreadPoolExecutor, Callable[[int], None]]]:
    """A thread, and what it tells its progress to; it ends soon where this one fails or is interrupted."""
    given_up = threading.Event()

    def tell(read_bytes: int) -> None:
        if given_up.is_set():
            raise Stopped
        advance(read_bytes)

    with ThreadPoolExecutor(1) as thread:
        try:
            yield thread, tell
        except BaseException:
            given_up.set()
            raise


@contextmanager
def _output_errors(staged: Path | None) -> Iterator[None]:
    """What the operating system says while files are written is said of the output."""
    try:
        yield
    except OSError as error:
        where = "the output" if staged is None else staged
        cure = "free some space, or choose another disk"
        raise OutputError(f"cannot be written ({error.strerror})", where=where, cure=cure) from error
