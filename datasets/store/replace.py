"""Putting a new episode in the place of an old one of the same recording."""

import shutil
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq

from navtool.base.errors import OutputError
from navtool.base.files import write_bytes, write_json
from navtool.datasets.store.description import Description
from navtool.datasets.store.journal import commit, staged
from navtool.datasets.store.layout import Layout
from navtool.datasets.store.metadata import episode_entry, info_of
from navtool.datasets.store.rewrite import rewrite_columns, rewrite_entry, stats_columns
from navtool.datasets.store.schema import arrow_schema, features_of, video_keys
from navtool.datasets.store.staged_episode import EpisodeFolder
from navtool.datasets.store.stats import Stats, aggregate, column_stats


def replace_episode(
    layout: Layout, new: EpisodeFolder, description: Description, episodes: int
) -> tuple[dict[str, Stats], int]:
    """Replace the episode of the new one's number, and return the data set's statistics and number of rows.

    Raises:
        OutputError: If a file cannot be written; the data set is then as it was.
    """
    number = new.numbering.episode_index
    spans = [_span(layout.episode_meta(episode)) for episode in range(episodes)]
    moved = new.rows - (spans[number][1] - spans[number][0])
    total = spans[-1][1] + moved
    targets = [layout.data(number), layout.episode(number), layout.episode_meta(number)]
    try:
        shutil.move(new.data, staged(layout.data(number)))
        shutil.move(new.beside, staged(layout.episode(number)))
        for key in video_keys(features_of(description.contents)):
            targets.append(layout.video(number, key))
            shutil.move(new.video(key), staged(layout.video(number, key)))
        task = str(description.robot["task"])
        write_bytes(staged(layout.episode_meta(number)), episode_entry(new, description, task))
        if moved:
            for episode in range(number + 1, episodes):
                _count_on(layout, description, episode, spans[episode], moved)
                targets += [layout.data(episode), layout.episode_meta(episode)]
    except OSError as error:
        where = layout.root
        raise OutputError(f"cannot be written ({error.strerror})", where=where, cure="check the space") from error
    metas = [layout.episode_meta(episode) for episode in range(episodes)]
    each = [entry_stats(staged(meta) if staged(meta).exists() else meta) for meta in metas]
    stats = aggregate(each)
    write_json(staged(layout.stats), stats)
    write_json(staged(layout.info), info_of(description, episodes, total))
    commit(layout.root, [*targets, layout.stats, layout.info], remove=[layout.beside / "labels.json"])
    return stats, total


def _count_on(layout: Layout, description: Description, episode: int, span: tuple[int, int], moved: int) -> None:
    """Write an episode's counters again, for a data set in which so many more rows stand before it."""
    first, end = span[0] + moved, span[1] + moved
    index = np.arange(first, end, dtype=np.int64)
    data, meta = layout.data(episode), layout.episode_meta(episode)
    rewrite_columns(data, staged(data), arrow_schema(features_of(description.contents)), {"index": index})
    changed = {"dataset_from_index": first, "dataset_to_index": end}
    rewrite_entry(meta, staged(meta), changed | stats_columns({"index": column_stats(index)}))


def _span(meta: Path) -> tuple[int, int]:
    entry = pq.read_table(meta, columns=["dataset_from_index", "dataset_to_index"]).to_pylist()[0]
    return int(entry["dataset_from_index"]), int(entry["dataset_to_index"])


def entry_stats(meta: Path) -> dict[str, Stats]:
    """The statistics in an episode's entry, by column."""
    stats: dict[str, Stats] = {}
    for name, value in pq.read_table(meta).to_pylist()[0].items():
        parts = name.split("/")
        if parts[0] == "stats":
            stats.setdefault("/".join(parts[1:-1]), {})[parts[-1]] = value
    return stats
