"""Labelling a data set: compute every episode's labels, write new files, replace the old ones in one step."""

import logging
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from navtool.base.errors import OutputError
from navtool.base.files import read_json, write_json
from navtool.base.lineage import code_version, config_hash, file_sha256
from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.base.progress import Progress, Silent
from navtool.datasets.labels.config import LabelConfig
from navtool.datasets.labels.episode import EpisodeLabels, label_episode
from navtool.datasets.labels.events import Bag, Event, read_events
from navtool.datasets.labels.report import EventsFile, LabelReport
from navtool.datasets.store.description import read_description
from navtool.datasets.store.journal import commit, finish, staged
from navtool.datasets.store.reader import Episode, NavDataset
from navtool.datasets.store.rewrite import rewrite_columns, rewrite_entry, stats_columns
from navtool.datasets.store.schema import arrow_schema
from navtool.datasets.store.stats import Stats, aggregate, column_stats
from navtool.datasets.store.writer import open_store

logger = logging.getLogger(__name__)

LABELS_VERSION = 1
SPEED_RATIO = 1.1
"""Poses and speeds of an odometry that differ by a larger factor are worth a note."""
_REBUILD = "run `navtool check` on it; ingest its recording again"


def label_dataset(
    root: Path,
    config: LabelConfig,
    events: Path | None = None,
    *,
    workers: int = 2,
    progress: Progress | None = None,
) -> LabelReport:
    """Give every row of a data set its label columns, by the rules and an events file.

    All files change in one journalled step: stopped at any moment, the data set has all old labels or all new ones.
    Only data files whose labels change are written again, one row group at a time; videos are never touched. The same
    data set, settings and events give the same bytes, however often it is run.

    Args:
        root: The data set.
        config: When a rule calls a portion failed.
        events: An events file, CSV or JSON; None for none.
        workers: Data files that are written at the same time.
        progress: Learns how far it is: an episode's work is to find its labels, and to write them where they change.

    Raises:
        DatasetsError: If it is no data set, another process writes to it, or the events file is faulty.
        OutputError: If a file cannot be written; the labels are then as they were.
    """
    read_description(root)
    with open_store(root):
        finish(root)
        try:
            return _label(root, config, events, workers, progress or Silent())
        except BaseException:
            # Before the journal this takes the new files away; after it, it completes the step.
            finish(root)
            raise


def _label(root: Path, config: LabelConfig, events: Path | None, workers: int, progress: Progress) -> LabelReport:
    dataset = NavDataset(root)
    report = LabelReport(dataset=str(root), episodes=len(dataset.episodes), rows=len(dataset))
    by_bag = _events_by_bag(dataset, events, report)
    progress.begin(len(dataset.episodes), 2 * len(dataset.episodes))
    labelled: list[EpisodeLabels] = []
    for episode in dataset.episodes:
        labels = label_episode(dataset, episode, config, by_bag.get(episode.source, []))
        _count(report, episode, labels)
        labelled.append(labels)
        progress.advance(1, 0)
    report.rewritten = [
        episode.index for episode in dataset.episodes if _differs(dataset, episode, labelled[episode.index])
    ]
    targets = _write_data(dataset, labelled, report.rewritten, workers, progress)
    targets += _write_stats(dataset, labelled)
    targets.append(_write_summary(dataset, config, report))
    commit(root, targets)
    logger.info("%s: labels of %d of %d episodes changed", root, len(report.rewritten), report.episodes)
    return report


def _events_by_bag(dataset: NavDataset, events: Path | None, report: LabelReport) -> dict[str, list[Event]]:
    if events is None:
        return {}
    by_bag: dict[str, list[Event]] = {}
    read = read_events(events, [_bag(dataset, episode) for episode in dataset.episodes])
    for event in read:
        by_bag.setdefault(event.bag, []).append(event)
    report.events = EventsFile(events.name, file_sha256(events), len(read))
    return by_bag


def _bag(dataset: NavDataset, episode: Episode) -> Bag:
    made: dict[str, Any] = read_json(dataset.layout.episode(episode.index) / "provenance.json", _REBUILD)
    start_ns, end_ns = int(made["start_ns"]), int(made["end_ns"])
    return Bag(episode.source, int(made.get("recording_start_ns", start_ns)), start_ns, end_ns)


def _count(report: LabelReport, episode: Episode, labels: EpisodeLabels) -> None:
    report.add_rules(episode.index, labels.rules)
    report.add_reasons(labels.reasons)
    known = labels.columns["label.known"]
    report.add_rows(labels.columns["label.outcome"], known)
    ratio = labels.speed_ratio
    if ratio is not None and not 1 / SPEED_RATIO <= ratio <= SPEED_RATIO:
        what = (
            f"{episode.source}: by its poses the odometry drives {ratio:.2f} times as far as by its speeds; "
            f"only {known.mean():.0%} of the steps are known"
        )
        report.notes.append(Note("labels.odometry-apart", what))


def _differs(dataset: NavDataset, episode: Episode, labels: EpisodeLabels) -> bool:
    rows = slice(episode.start, episode.stop)
    return any(not np.array_equal(dataset.column(name)[rows], values) for name, values in labels.columns.items())


def _write_data(
    dataset: NavDataset, labelled: list[EpisodeLabels], changed: list[int], workers: int, progress: Progress
) -> list[Path]:
    targets = [dataset.layout.data(index) for index in changed]
    needed = sum(target.stat().st_size for target in targets)
    free = shutil.disk_usage(dataset.root).free
    if free < needed * 1.05:
        raise OutputError(
            f"{needed / 1e9:.1f} GB are needed for the new files, {free / 1e9:.1f} GB are free",
            where=dataset.root,
            cure="free some space: the old files go only when all new ones are there",
        )

    unchanged = len(labelled) - len(changed)
    progress.advance(0, unchanged)

    def write_labels(index: int) -> None:
        target = dataset.layout.data(index)
        rewrite_columns(target, staged(target), arrow_schema(dataset.features), labelled[index].columns)

    try:
        with ThreadPoolExecutor(max_workers=workers) as pool:
            for done, _ in enumerate(pool.map(write_labels, changed)):
                progress.advance(1, 0)
                progress.done(unchanged + done + 1, dataset.episodes[changed[done]].source)
    except OSError as error:
        cure = "check the disk's space and the folder's rights"
        raise OutputError(f"cannot be written ({error.strerror})", where=dataset.root, cure=cure) from error
    return targets


def _write_stats(dataset: NavDataset, labelled: list[EpisodeLabels]) -> list[Path]:
    """Statistics of the label columns, in each episode's metadata and over all."""
    per_episode: list[dict[str, Stats]] = [
        {key: column_stats(values) for key, values in labels.columns.items() if values.dtype != np.object_}
        for labels in labelled
    ]
    targets = [dataset.layout.episode_meta(index) for index in range(len(labelled))]
    for target, stats in zip(targets, per_episode, strict=True):
        rewrite_entry(target, staged(target), stats_columns(stats))
    total = read_json(dataset.layout.stats, _REBUILD) | aggregate(per_episode)
    write_json(staged(dataset.layout.stats), total)
    return [*targets, dataset.layout.stats]


def _write_summary(dataset: NavDataset, config: LabelConfig, report: LabelReport) -> Path:
    target = dataset.layout.beside / "labels.json"
    reported = {key: value for key, value in report.to_json().items() if key not in ("dataset", "rewritten")}
    made_with = {"config": plain(config), "config_hash": config_hash(config), "code_version": code_version()}
    write_json(staged(target), {"schema_version": LABELS_VERSION} | reported | made_with)
    return target
