"""All columns of an episode's rows, once its images and clouds were read."""

from collections.abc import Sequence

import numpy as np

from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.segment import Segment, SegmentResult
from navtool.datasets.store.data_file import Column
from navtool.datasets.store.schema import CLOUD_RELIABILITY_KEYS, COUNT_KEY, camera_reliability_keys
from navtool.datasets.store.staged_episode import Numbering


def joined_columns(
    plan: EpisodePlan,
    segments: Sequence[Segment],
    results: Sequence[SegmentResult],
    numbering: Numbering,
    fps: int,
) -> dict[str, Column]:
    """The columns by key; a tick whose image or cloud was lost is not valid."""
    columns = {key: values.copy() for key, values in plan.columns.items()}
    columns |= _unread_columns(plan) | _counters(int(plan.ticks_ns.size), numbering, fps)
    for segment, result in zip(segments, results, strict=True):
        rows = slice(segment.first_tick, segment.first_tick + segment.ticks)
        for key, values in result.columns.items():
            columns[key][rows] = values
        for stream, ticks in result.lost.items():
            columns[f"valid.{stream}"][rows][ticks] = False
            columns[f"sync.error_s.{stream}"][rows][ticks] = 0.0
    return columns


def _unread_columns(plan: EpisodePlan) -> dict[str, Column]:
    """What segments fill in, all 0."""
    ticks = plan.ticks_ns.size
    columns: dict[str, Column] = {}
    for stream in plan.contents.camera_streams:
        columns |= {key: np.zeros(ticks, dtype=np.float32) for key in camera_reliability_keys(stream)}
    if plan.contents.lidar:
        columns |= {key: np.zeros(ticks, dtype=np.float32) for key in CLOUD_RELIABILITY_KEYS}
        columns[COUNT_KEY] = np.zeros(ticks, dtype=np.int64)
    return columns


def _counters(rows: int, numbering: Numbering, fps: int) -> dict[str, Column]:
    frame_index = np.arange(rows, dtype=np.int64)
    return {
        "timestamp": (frame_index / fps).astype(np.float32),
        "frame_index": frame_index,
        "episode_index": np.full_like(frame_index, numbering.episode_index),
        "index": frame_index + numbering.index_from,
        "task_index": np.zeros_like(frame_index),
    }
