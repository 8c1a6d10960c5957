"""Is this data set whole and plausible? Every finding says what, where and how bad."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

import av
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from navtool.datasets.errors import DatasetsError
from navtool.datasets.files import read_json
from navtool.datasets.lineage import plain
from navtool.datasets.reader import Episode, NavDataset
from navtool.datasets.schema import (
    CLOUD_RELIABILITY_KEYS,
    CLOUD_SIZE,
    COUNT_KEY,
    IMAGE_KEY,
    IMAGE_RELIABILITY_KEYS,
    POINTS_KEY,
    STATE_KEY,
    TIMESTAMP_NS_KEY,
    arrow_schema,
)
from navtool.pipeline.arrays import Array

INVALID_SHARE = 0.05
"""A stream that is not valid in more than this share of an episode's rows is worth a warning."""
FROZEN_S = 5.0
"""A robot whose measured speed does not change in the last digit for this long, while not at rest, is suspicious."""


class Severity(StrEnum):
    """How bad a finding is: a data set with a FAIL must not be trained on."""

    FAIL = "FAIL"
    WARN = "WARN"


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is wrong."""

    severity: Severity
    check: str
    where: str
    message: str


@dataclass(slots=True)
class CheckReport:
    """All findings, and what was looked at."""

    dataset: str
    episodes: int = 0
    rows: int = 0
    checks: list[str] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)

    @property
    def passed(self) -> bool:
        """Whether nothing failed."""
        return all(finding.severity is not Severity.FAIL for finding in self.findings)

    def to_json(self) -> dict[str, object]:
        """The report as ``navtool check --json`` prints it."""
        return {"passed": self.passed, **dict(plain(self).items())}  # type: ignore[attr-defined]


def check_dataset(root: Path, progress: Callable[[str], None] | None = None) -> CheckReport:
    """Look at everything in a data set, down to the last row, frame and footer.

    Nothing is changed. Damage is reported as a finding; only a folder that is no data set of ours raises.

    Args:
        progress: Called with the name of each check as it begins.

    Raises:
        DatasetsError: If there is no data set of this schema version here.
    """
    report = CheckReport(str(root))
    try:
        dataset = NavDataset(root)
    except DatasetsError as error:
        if error.where == str(root):
            raise
        report.checks.append("metadata")
        report.findings.append(Finding(Severity.FAIL, "metadata", str(error.where), error.what))
        return report
    report.episodes, report.rows = len(dataset.episodes), len(dataset)
    for name, check in _CHECKS.items():
        if progress is not None:
            progress(name)
        report.checks.append(name)
        try:
            report.findings += [Finding(severity, name, where, what) for severity, where, what in check(dataset)]
        except DatasetsError as error:
            report.findings.append(Finding(Severity.FAIL, name, str(error.where), error.what))
    return report


_Findings = Iterator[tuple[Severity, str, str]]


def _metadata(dataset: NavDataset) -> _Findings:
    info = read_json(dataset.layout.info, "")
    where = "meta/info.json"
    if info.get("total_frames") != len(dataset):
        yield Severity.FAIL, where, f"counts {info.get('total_frames')} rows, the episodes have {len(dataset)}"
    if info.get("fps") != dataset.fps:
        yield Severity.FAIL, where, f"says {info.get('fps')} fps, navtool/dataset.json {dataset.fps}"
    if info.get("features") != {key: feature.to_json(dataset.fps) for key, feature in dataset.features.items()}:
        yield Severity.FAIL, where, "lists other columns than this schema version has"
    stats = read_json(dataset.layout.stats, "")
    lacking = [key for key, feature in dataset.features.items() if feature.dtype != "string" and key not in stats]
    if lacking:
        yield Severity.FAIL, "meta/stats.json", f"has no statistics of {', '.join(lacking)}"
    expected = 0
    for episode in dataset.episodes:
        if episode.start != expected or len(episode) < 1:
            yield Severity.FAIL, _name(episode), f"rows {episode.start} to {episode.stop} do not follow {expected}"
        expected = episode.stop


def _files(dataset: NavDataset) -> _Findings:
    schema = arrow_schema(dataset.features)
    for episode in dataset.episodes:
        path = dataset.layout.data(episode.index)
        try:
            file = pq.ParquetFile(path)
        except (OSError, pa.ArrowException) as error:
            yield Severity.FAIL, _short(dataset, path), f"cannot be opened: {_first_line(error)}"
            continue
        with file:
            if file.metadata.num_rows != len(episode):
                yield Severity.FAIL, _short(dataset, path), f"{file.metadata.num_rows} rows instead of {len(episode)}"
            if not file.schema_arrow.remove_metadata().equals(schema.remove_metadata()):
                yield Severity.FAIL, _short(dataset, path), "columns differ from the schema's"
        beside = dataset.layout.episode(episode.index)
        for extra in sorted(beside.rglob("*.parquet")):
            try:
                pq.read_metadata(extra)
            except (OSError, pa.ArrowException) as error:
                yield Severity.FAIL, _short(dataset, extra), f"cannot be opened: {_first_line(error)}"
        for name in ("provenance.json", "calibration.json", "sync.json"):
            try:
                read_json(beside / name, "")
            except DatasetsError as error:
                yield Severity.FAIL, _short(dataset, beside / name), error.what


def _counters(dataset: NavDataset) -> _Findings:
    index = dataset.column("index")
    if not np.array_equal(index, np.arange(len(dataset))):
        yield Severity.FAIL, "index", "does not count the rows"
    stamps, seconds = dataset.column(TIMESTAMP_NS_KEY), dataset.column("timestamp")
    frames, numbers = dataset.column("frame_index"), dataset.column("episode_index")
    for episode in dataset.episodes:
        rows = slice(episode.start, episode.stop)
        if not np.array_equal(frames[rows], np.arange(len(episode))):
            yield Severity.FAIL, _name(episode), "frame_index does not count the frames"
        if not (numbers[rows] == episode.index).all():
            yield Severity.FAIL, _name(episode), "rows carry another episode_index"
        if np.abs(seconds[rows] - np.arange(len(episode)) / dataset.fps).max() > 1e-4 * max(1.0, len(episode) / 1000):
            yield Severity.FAIL, _name(episode), "timestamp is not frame_index / fps"
        steps = np.diff(stamps[rows])
        if (steps <= 0).any():
            yield Severity.FAIL, _name(episode), f"{int((steps <= 0).sum())} true stamps do not increase"
        elif (np.abs(steps - 1e9 / dataset.fps) > 1).any():
            yield Severity.FAIL, _name(episode), "true stamps are not on the grid"


def _values(dataset: NavDataset) -> _Findings:
    for key, feature in dataset.features.items():
        if feature.dtype != "float32" or key == POINTS_KEY:
            continue
        bad = ~np.isfinite(dataset.column(key))
        if bad.any():
            yield Severity.FAIL, key, f"{int(bad.sum())} values are NaN or infinite"
    for key in (*IMAGE_RELIABILITY_KEYS, *CLOUD_RELIABILITY_KEYS, "label.confidence"):
        if key in dataset.features:
            values = dataset.column(key)
            outside = int(((values < 0) | (values > 1)).sum())
            if outside:
                yield Severity.FAIL, key, f"{outside} values are outside 0 to 1"
    outcomes = dataset.column("label.outcome")
    if not np.isin(outcomes, (0, 1)).all():
        yield Severity.FAIL, "label.outcome", "has values other than 0 and 1"


def _clouds(dataset: NavDataset) -> _Findings:
    if POINTS_KEY not in dataset.features:
        return
    counts = dataset.column(COUNT_KEY)
    valid = dataset.column("valid.lidar")
    if ((counts < 0) | (counts > CLOUD_SIZE)).any():
        yield Severity.FAIL, COUNT_KEY, f"counts outside 0 to {CLOUD_SIZE}"
        return
    for episode in dataset.episodes:
        padded = not_finite = 0
        for row in range(episode.start, episode.stop):
            points = dataset.points(row)
            not_finite += int(not np.isfinite(points).all())
            padded += int(not np.array_equal(points, np.resize(points[: counts[row]], points.shape)))
        if not_finite:
            yield Severity.FAIL, _name(episode), f"{not_finite} clouds have points that are NaN or infinite"
        if padded:
            yield Severity.FAIL, _name(episode), f"{padded} clouds hold more points than their count says"
        empty = int((valid & (counts == 0))[episode.start : episode.stop].sum())
        if empty:
            yield Severity.WARN, _name(episode), f"{empty} clouds have no point in the front half plane"


def _video(dataset: NavDataset) -> _Findings:
    if IMAGE_KEY not in dataset.features:
        return
    for episode in dataset.episodes:
        path = dataset.layout.video(episode.index)
        try:
            with av.open(str(path)) as container:
                frames, changes, previous = 0, 0, None
                for frame in container.decode(video=0):
                    thumbnail = frame.reformat(width=32, height=24, format="gray").to_ndarray()
                    changes += int(previous is not None and not np.array_equal(thumbnail, previous))
                    previous, frames = thumbnail, frames + 1
        except (OSError, av.FFmpegError) as error:
            yield Severity.FAIL, _short(dataset, path), f"cannot be decoded: {_first_line(error)}"
            continue
        if frames != len(episode):
            yield Severity.FAIL, _short(dataset, path), f"{frames} frames instead of {len(episode)}"
        if changes == 0 and frames > 1:
            yield Severity.WARN, _short(dataset, path), "every frame looks the same"


def _streams(dataset: NavDataset) -> _Findings:
    for stream in dataset.description.contents.streams():
        valid = dataset.column(f"valid.{stream}")
        for episode in dataset.episodes:
            share = 1.0 - float(valid[episode.start : episode.stop].mean())
            if share > INVALID_SHARE:
                yield Severity.WARN, _name(episode), f"{stream} is not valid in {share:.0%} of the rows"
    speeds = dataset.column(STATE_KEY)
    window = round(FROZEN_S * dataset.fps)
    for episode in dataset.episodes:
        rows = speeds[episode.start : episode.stop]
        moving = (np.abs(rows) > 1e-6).any(axis=1)
        same = np.concatenate([[False], (np.diff(rows, axis=0) == 0).all(axis=1)]) & moving
        longest = _longest_run(same)
        if longest >= window:
            yield Severity.WARN, _name(episode), f"the measured speed is frozen for {longest / dataset.fps:.1f} s"


def _labels(dataset: NavDataset) -> _Findings:
    if not (dataset.layout.beside / "labels.json").is_file():
        yield Severity.WARN, "label.*", "not labelled yet: run `navtool label`"
        return
    outcomes, known = dataset.column("label.outcome"), dataset.column("label.known")
    if not known.any():
        yield Severity.WARN, "label.known", "no step is known: nothing can be trained on it"
    if np.unique(outcomes).size == 1:
        word = "success" if outcomes[0] == 1 else "failure"
        yield Severity.WARN, "label.outcome", f"every row is a {word}: a model cannot learn to tell them apart"


def _calibrations(dataset: NavDataset) -> _Findings:
    for episode in dataset.episodes:
        calibration = dataset.calibration(episode.index)
        contents = dataset.description.contents
        lacking = [
            name
            for name, value, wanted in (
                ("camera", calibration.camera, contents.image),
                ("base_camera", calibration.base_camera, contents.image),
                ("base_lidar", calibration.base_lidar, contents.lidar),
                ("base_imu", calibration.base_imu, contents.imu),
            )
            if wanted and value is None
        ]
        if lacking:
            yield Severity.WARN, _name(episode), f"{', '.join(lacking)} unknown"


def _leakage(dataset: NavDataset) -> _Findings:
    seen: dict[str, str] = {}
    for entry in dataset.lineage()["recordings"]:
        if entry["sha256"] in seen:
            yield Severity.FAIL, entry["source"], f"is the same recording as {seen[entry['sha256']]}"
        seen[entry["sha256"]] = entry["source"]
    if len(dataset.episodes) > 1 and not all(episode.place for episode in dataset.episodes):
        yield Severity.WARN, "places", "unknown for some episodes: splits can only keep runs apart (ingest with place=)"


_CHECKS: dict[str, Callable[[NavDataset], _Findings]] = {
    "metadata": _metadata,
    "files": _files,
    "counters": _counters,
    "values": _values,
    "clouds": _clouds,
    "video": _video,
    "streams": _streams,
    "labels": _labels,
    "calibration": _calibrations,
    "leakage": _leakage,
}


def _name(episode: Episode) -> str:
    return f"episode {episode.index} ({episode.source})"


def _short(dataset: NavDataset, path: Path) -> str:
    return path.relative_to(dataset.root).as_posix()


def _first_line(error: BaseException) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__


def _longest_run(flags: Array) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    return int((edges[1::2] - edges[::2]).max(initial=0))
