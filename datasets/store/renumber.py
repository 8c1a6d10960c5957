"""A staged episode moved to another number of its data set."""

from dataclasses import replace

import numpy as np

from navtool.datasets.store.rewrite import rewrite_columns
from navtool.datasets.store.schema import Contents, arrow_schema, features_of
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering
from navtool.datasets.store.stats import column_stats


def renumber(folder: EpisodeFolder, numbering: Numbering, contents: Contents) -> EpisodeFolder:
    """The episode with other counters; nothing is written where it has these already."""
    if folder.numbering == numbering:
        return folder
    first = numbering.index_from
    counters = {
        "index": np.arange(first, first + folder.rows, dtype=np.int64),
        "episode_index": np.full(folder.rows, numbering.episode_index, dtype=np.int64),
    }
    moved = folder.data.with_suffix(".moved")
    rewrite_columns(folder.data, moved, arrow_schema(features_of(contents)), counters)
    moved.replace(folder.data)
    stats = folder.stats | {key: column_stats(values) for key, values in counters.items()}
    return replace(folder, numbering=numbering, stats=stats)
