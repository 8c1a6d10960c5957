"""Recordings in, data set out: the orchestrator of ingest and its report."""

import logging
import resource
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from navtool.datasets.description import Description
from navtool.datasets.errors import DatasetsError, OutputError
from navtool.datasets.files import write_json
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.episode import EpisodeFolder, Numbering, write_episode
from navtool.datasets.ingest.natural import expand
from navtool.datasets.ingest.plan import EpisodePlan, plan_episode, source_name
from navtool.datasets.ingest.store import Store, open_store
from navtool.datasets.lineage import code_version, config_hash, plain, recording_sha256
from navtool.datasets.recording import open_recording
from navtool.datasets.robot import RobotConfig
from navtool.datasets.schema import Contents, features_of

logger = logging.getLogger(__name__)


@runtime_checkable
class Progress(Protocol):
    """Who wants to know how far ingest is; the command line draws it."""

    def recording(self, number: int, total: int, name: str, size_bytes: int) -> None:
        """A recording begins; its messages will be read twice at the most."""

    def advance(self, read_bytes: int) -> None:
        """This many bytes of messages were read."""


class Silent:
    """Wants to know nothing."""

    def recording(self, number: int, total: int, name: str, size_bytes: int) -> None:
        """Ignore it."""

    def advance(self, read_bytes: int) -> None:
        """Ignore it."""


@dataclass(frozen=True, slots=True)
class Quarantined:
    """A recording that gave no episode, and why."""

    path: str
    reason: str


@dataclass(slots=True)
class EpisodeSummary:
    """One episode as ingest reports it."""

    episode: int | None
    """Its number in the data set; None in a dry run."""
    source: str
    rows: int
    topics: dict[str, str]
    not_used: list[dict[str, Any]]
    dropped: dict[str, int]
    sync: dict[str, Any]
    notes: list[str]


@dataclass(slots=True)
class IngestReport:
    """What an ingest did."""

    dataset: str
    dry_run: bool
    episodes: list[EpisodeSummary] = field(default_factory=list)
    skipped: list[str] = field(default_factory=list)
    """Recordings that the data set had already."""
    quarantined: list[Quarantined] = field(default_factory=list)
    seconds: float = 0.0
    bytes_in: int = 0
    peak_rss_mib: float = 0.0

    @property
    def rows(self) -> int:
        """Rows of the new episodes."""
        return sum(episode.rows for episode in self.episodes)

    @property
    def dropped(self) -> dict[str, int]:
        """Messages that reached no row, by reason, over all episodes."""
        total: dict[str, int] = {}
        for episode in self.episodes:
            for reason, count in episode.dropped.items():
                total[reason] = total.get(reason, 0) + count
        return total

    def to_json(self) -> dict[str, object]:
        """The report as ``navtool ingest --json`` prints it."""
        return {
            "dataset": self.dataset,
            "dry_run": self.dry_run,
            "episodes": len(self.episodes),
            "rows": self.rows,
            "dropped": self.dropped,
            "quarantined": [plain(entry) for entry in self.quarantined],
            "skipped": self.skipped,
            "seconds": round(self.seconds, 3),
            "bytes_in": self.bytes_in,
            "peak_rss_mib": round(self.peak_rss_mib, 1),
            "recordings": [plain(episode) for episode in self.episodes],
        }


def ingest(
    paths: Sequence[Path],
    out: Path,
    robot: RobotConfig,
    config: IngestConfig,
    *,
    dry_run: bool = False,
    allow_missing: bool = False,
    progress: Progress | None = None,
) -> IngestReport:
    """Turn each recording into an episode of the data set at ``out``, in the natural order of their paths.

    An episode is in the data set whole, or it is not; recordings that are there already (same bytes, same settings)
    are skipped. A recording that cannot become an episode is quarantined with its reason and ends nothing else. The
    same recordings and settings give the same files.

    Args:
        paths: Bag files, rosbag2 folders, or folders that hold such; searched for recordings to any depth.
        allow_missing: Take recordings that lack streams of the data set; their rows are not valid there.
        dry_run: Read and plan everything, write nothing.

    Raises:
        DatasetsError: If a path does not exist, the data set was made with another rate or schema or is being written,
            or it cannot be written.
    """
    started = time.monotonic()
    watch = progress or Silent()
    recordings = expand(paths)
    report = IngestReport(str(out), dry_run)
    if dry_run:
        for number, path in enumerate(recordings):
            watch.recording(number, len(recordings), source_name(path), _size(path))
            _try(report, path, partial(_plan_only, path, robot, config, watch.advance))
            report.bytes_in += _size(path)
    else:
        with open_store(out) as store:
            _refuse_other_settings(store, config)
            known = {entry["sha256"]: entry for entry in store.provenance()}
            for number, path in enumerate(recordings):
                size = _size(path)
                watch.recording(number, len(recordings), source_name(path), size)
                sha256 = recording_sha256(path)
                if sha256 in known:
                    _skip(report, path, known[sha256], robot, config)
                    continue
                job = _Job(path, sha256, size, robot, config, allow_missing, watch.advance)
                summary = _try(report, path, partial(_add_episode, store, job))
                report.bytes_in += size
                if summary is not None:
                    known[sha256] = store.provenance_of(store.episodes - 1)
    report.seconds = time.monotonic() - started
    report.peak_rss_mib = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return report


@dataclass(frozen=True, slots=True)
class _Job:
    path: Path
    sha256: str
    size: int
    robot: RobotConfig
    config: IngestConfig
    allow_missing: bool
    advance: Callable[[int], None]


def _try(report: IngestReport, path: Path, work: Callable[[], EpisodeSummary]) -> EpisodeSummary | None:
    try:
        summary = work()
    except OutputError:
        raise
    except DatasetsError as error:
        logger.warning("%s", error)
        reason = error.what if error.where in (None, str(path)) else f"{error.where}: {error.what}"
        report.quarantined.append(Quarantined(str(path), reason if error.cure is None else f"{reason} ({error.cure})"))
        return None
    report.episodes.append(summary)
    return summary


def _plan_only(path: Path, robot: RobotConfig, config: IngestConfig, advance: Callable[[int], None]) -> EpisodeSummary:
    with open_recording(path) as recording:
        return _summary(plan_episode(recording, robot, config, None, advance), path, None, {})


def _add_episode(store: Store, job: _Job) -> EpisodeSummary:
    store.clear()  # what a recording that failed in its second pass had staged is not this one's
    fixed = None if store.description is None else store.description.contents
    staged = EpisodeFolder(store.layout.staging, Numbering(store.episodes, store.rows))
    try:
        with open_recording(job.path) as recording:
            plan = plan_episode(recording, job.robot, job.config, fixed, job.advance)
            if fixed is not None:
                _refuse_other_contents(fixed, plan, allow_missing=job.allow_missing)
            write_episode(recording, plan, features_of(plan.contents), job.config, staged, job.advance)
    except OSError as error:
        cure = "free some space, or choose another disk"
        raise OutputError(f"cannot be written ({error.strerror})", where=store.layout.root, cure=cure) from error
    dropped = plan.dropped | {f"{name}: cannot be decoded": count for name, count in staged.undecodable.items()}
    if staged.points_nonfinite:
        dropped["lidar points: not finite"] = staged.points_nonfinite
    plan.dropped = dropped
    write_json(staged.beside / "calibration.json", plan.calibration.to_json())
    summary = _summary(plan, job.path, staged.numbering.episode_index, dropped)
    write_json(staged.beside / "sync.json", plan.sync_report | {"dropped": dropped, "notes": summary.notes})
    store.commit(staged, _description(plan, job), _provenance(plan, job, summary))
    return summary


def _summary(plan: EpisodePlan, path: Path, episode: int | None, dropped: dict[str, int]) -> EpisodeSummary:
    return EpisodeSummary(
        episode=episode,
        source=source_name(path),
        rows=int(plan.ticks_ns.size),
        topics=plan.topics.streams(),
        not_used=[dict(plain(topic)) for topic in plan.topics.not_used],  # type: ignore[call-overload]
        dropped=dropped or plan.dropped,
        sync=dict(plan.sync_report),
        notes=plan.notes,
    )


def _description(plan: EpisodePlan, job: _Job) -> Description:
    robot, config = plain(job.robot), plain(job.config)
    return Description(
        fps=job.config.fps,
        contents=plan.contents,
        robot=robot,  # type: ignore[arg-type]
        ingest=config,  # type: ignore[arg-type]
        config_hash=_settings_hash(job.robot, job.config),
    )


def _provenance(plan: EpisodePlan, job: _Job, summary: EpisodeSummary) -> dict[str, object]:
    place = job.path.resolve().parent.name if job.config.place == "{parent}" else job.config.place
    return {
        "source": summary.source,
        "sha256": job.sha256,
        "bytes": job.size,
        "place": place,
        "recording_start_ns": plan.recording_start_ns,
        "start_ns": int(plan.ticks_ns[0]),
        "end_ns": int(plan.ticks_ns[-1]),
        "topics": summary.topics,
        "not_used": summary.not_used,
        "config_hash": _settings_hash(job.robot, job.config),
        "code_version": code_version(),
    }


def _settings_hash(robot: RobotConfig, config: IngestConfig) -> str:
    """Hash of what decides an episode's content; the place is only a name."""
    settings = plain(config)
    return config_hash({"robot": robot, "ingest": {key: value for key, value in settings.items() if key != "place"}})  # type: ignore[attr-defined]


def _skip(report: IngestReport, path: Path, entry: dict[str, Any], robot: RobotConfig, config: IngestConfig) -> None:
    if entry["config_hash"] != _settings_hash(robot, config):
        raise DatasetsError(
            "is in the data set already, read with another robot configuration",
            where=path,
            cure="use the same robot to append, or ingest into another folder",
        )
    report.skipped.append(source_name(path))


def _refuse_other_settings(store: Store, config: IngestConfig) -> None:
    """One data set has one rate, one set of tolerances, one way to thin clouds and to judge reliability."""
    if store.description is None:
        return
    there, asked = _flat(store.description.ingest), _flat(plain(config))
    other = [key for key in asked if key != "place" and there.get(key) != asked[key]]
    if other:
        raise DatasetsError(
            "; ".join(f"the data set has {key}={there.get(key)}, asked for {asked[key]}" for key in other),
            where=store.layout.root,
            cure=f"use {' '.join(f'{key}={there.get(key)}' for key in other)}, or ingest into another folder",
        )


def _flat(value: object, prefix: str = "") -> dict[str, object]:
    """Nested settings by their dotted keys."""
    if not isinstance(value, dict):
        return {prefix.removesuffix("."): value}
    return {key: leaf for name, entry in value.items() for key, leaf in _flat(entry, f"{prefix}{name}.").items()}


def _refuse_other_contents(fixed: Contents, plan: EpisodePlan, *, allow_missing: bool) -> None:
    there, here = _streams_of(fixed), _streams_of(plan.found)
    missing = [name for name in there if name not in here]
    if missing and not allow_missing:
        raise DatasetsError(
            f"lacks {', '.join(missing)}, which the data set has",
            cure="pass --allow-missing to take it with these marked as not valid, or use another folder",
        )
    extra = [name for name in here if name not in there]
    if extra:
        plan.notes.append(f"{', '.join(extra)}: not used, since the data set's first recording did not have them")


def _streams_of(contents: Contents) -> tuple[str, ...]:
    return tuple(name for name in contents.streams() if name not in ("state", "action"))


def _size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else sum(e.stat().st_size for e in path.rglob("*") if e.is_file())
