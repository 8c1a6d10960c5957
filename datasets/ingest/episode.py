"""An episode's staged files: its segments joined into the files of a LeRobot data set and those beside them."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from jaxtyping import Float32

from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.segment import Segment, SegmentResult, points_part, video_part
from navtool.datasets.store.data_file import write_data
from navtool.datasets.store.rewrite import rewrite_columns
from navtool.datasets.store.schema import (
    CLOUD_RELIABILITY_KEYS,
    CLOUD_SIZE,
    COUNT_KEY,
    IMAGE_KEY,
    IMAGE_RELIABILITY_KEYS,
    POINTS_KEY,
    Contents,
    Feature,
    arrow_schema,
    features_of,
)
from navtool.datasets.store.staged_episode import EpisodeFolder, Numbering
from navtool.datasets.store.stats import CloudStats, ImageStats, column_stats
from navtool.datasets.store.video import join_videos
from navtool.pipeline.arrays import Array


def join_segments(
    plan: EpisodePlan,
    segments: Sequence[Segment],
    results: Sequence[SegmentResult],
    features: dict[str, Feature],
    fps: int,
    folder: EpisodeFolder,
    reached: Callable[[int], None],
) -> None:
    """Write the episode's data file and video out of its segments, and take the segments' own files away.

    Args:
        plan: Its columns are filled in.
        folder: Where the segments lie; its rows and statistics are filled in.
        reached: Called with the number of segments before each; ends the work where it raises.
    """
    images, clouds = ImageStats(), CloudStats()
    _add_empty_columns(plan)
    _add_counters(plan, folder.numbering, fps)
    for segment, result in zip(segments, results, strict=True):
        rows = slice(segment.first_tick, segment.first_tick + segment.ticks)
        for key, values in result.columns.items():
            plan.columns[key][rows] = values
        for stream, ticks in result.lost.items():
            plan.columns[f"valid.{stream}"][rows][ticks] = False
            plan.columns[f"sync.error_s.{stream}"][rows][ticks] = 0.0
        images.merge(result.images)
        clouds.merge(result.clouds)
    points = [points_part(folder.root, segment.number) for segment in segments] if plan.contents.lidar else []
    write_data(folder.data, features, plan.columns, _pieces(points, reached))
    videos = [video_part(folder.root, segment.number) for segment in segments] if plan.contents.image else []
    if videos:
        join_videos(videos, folder.video, fps)
    for part in (*points, *videos):
        part.unlink()
    folder.rows = plan.ticks_ns.size
    for key, feature in features.items():
        if key == IMAGE_KEY:
            folder.stats[key] = images.result()
        elif key == POINTS_KEY:
            folder.stats[key] = clouds.result()
        elif feature.dtype != "string":
            folder.stats[key] = column_stats(plan.columns[key])


def _pieces(points: Sequence[Path], reached: Callable[[int], None]) -> Iterator[Float32[Array, "ticks 10000 3"]]:
    for number, path in enumerate(points):
        reached(number)
        yield np.memmap(path, np.float32, "r").reshape(-1, CLOUD_SIZE, 3)


def renumber(folder: EpisodeFolder, numbering: Numbering, contents: Contents) -> None:
    """Move a staged episode to another place in the data set; nothing is done where it has that place already."""
    if folder.numbering == numbering:
        return
    first = numbering.index_from
    counters = {
        "index": np.arange(first, first + folder.rows, dtype=np.int64),
        "episode_index": np.full(folder.rows, numbering.episode_index, dtype=np.int64),
    }
    moved = folder.data.with_suffix(".moved")
    rewrite_columns(folder.data, moved, arrow_schema(features_of(contents)), counters)
    moved.replace(folder.data)
    folder.stats |= {key: column_stats(values) for key, values in counters.items()}
    folder.numbering = numbering


def _add_empty_columns(plan: EpisodePlan) -> None:
    ticks = plan.ticks_ns.size
    if plan.contents.image:
        plan.columns |= {key: np.zeros(ticks, dtype=np.float32) for key in IMAGE_RELIABILITY_KEYS}
    if plan.contents.lidar:
        plan.columns |= {key: np.zeros(ticks, dtype=np.float32) for key in CLOUD_RELIABILITY_KEYS}
        plan.columns[COUNT_KEY] = np.zeros(ticks, dtype=np.int64)


def _add_counters(plan: EpisodePlan, numbering: Numbering, fps: int) -> None:
    frame_index = np.arange(plan.ticks_ns.size, dtype=np.int64)
    plan.columns |= {
        "timestamp": (frame_index / fps).astype(np.float32),
        "frame_index": frame_index,
        "episode_index": np.full_like(frame_index, numbering.episode_index),
        "index": frame_index + numbering.index_from,
        "task_index": np.zeros_like(frame_index),
    }
