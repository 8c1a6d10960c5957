"""Putting a new episode in the place of an old one of the same recording."""

import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from navtool.datasets.description import Description
from navtool.datasets.errors import OutputError
from navtool.datasets.files import write_bytes, write_json
from navtool.datasets.ingest.episode import EpisodeFolder
from navtool.datasets.ingest.metadata import episode_entry, info_of
from navtool.datasets.ingest.stats import Stats, aggregate, column_stats
from navtool.datasets.journal import commit, staged
from navtool.datasets.layout import Layout
from navtool.datasets.rewrite import rewrite_columns, rewrite_stats


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
        if description.contents.image:
            targets.append(layout.video(number))
            shutil.move(new.video, staged(layout.video(number)))
        task = str(description.robot["task"])
        write_bytes(staged(layout.episode_meta(number)), episode_entry(new, description, task))
        if moved:
            for episode in range(number + 1, episodes):
                _count_on(layout, episode, spans[episode], moved)
                targets += [layout.data(episode), layout.episode_meta(episode)]
    except OSError as error:
        where = layout.root
        raise OutputError(f"cannot be written ({error.strerror})", where=where, cure="check the space") from error
    metas = [layout.episode_meta(episode) for episode in range(episodes)]
    stats = aggregate([_stats(staged(meta) if staged(meta).exists() else meta) for meta in metas])
    write_json(staged(layout.stats), stats)
    write_json(staged(layout.info), info_of(description, episodes, total))
    commit(layout.root, [*targets, layout.stats, layout.info], remove=[layout.beside / "labels.json"])
    return stats, total


def _count_on(layout: Layout, episode: int, span: tuple[int, int], moved: int) -> None:
    """Write an episode's counters again, for a data set in which so many more rows stand before it."""
    index = np.arange(span[0] + moved, span[1] + moved, dtype=np.int64)
    data, meta = layout.data(episode), layout.episode_meta(episode)
    rewrite_columns(data, staged(data), {"index": index})
    rewrite_stats(meta, staged(meta), {"index": column_stats(index)})
    table = pq.read_table(staged(meta))
    for name, value in zip(("dataset_from_index", "dataset_to_index"), (index[0], index[-1] + 1), strict=True):
        place = table.schema.get_field_index(name)
        table = table.set_column(place, table.schema.field(place), pa.array([int(value)], pa.int64()))
    pq.write_table(table, staged(meta))


def _span(meta: Path) -> tuple[int, int]:
    entry = pq.read_table(meta, columns=["dataset_from_index", "dataset_to_index"]).to_pylist()[0]
    return int(entry["dataset_from_index"]), int(entry["dataset_to_index"])


def _stats(meta: Path) -> dict[str, Stats]:
    """The statistics in an episode's entry, by column."""
    stats: dict[str, Stats] = {}
    for name, value in pq.read_table(meta).to_pylist()[0].items():
        parts = name.split("/")
        if parts[0] == "stats":
            stats.setdefault("/".join(parts[1:-1]), {})[parts[-1]] = value
    return stats
