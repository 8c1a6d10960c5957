"""Images and clouds of an episode: which message serves which ticks."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Int64

from navtool.datasets.decode.picture_view import AS_RECORDED, PictureView
from navtool.datasets.ingest.grid import Grid
from navtool.datasets.store.data_file import Column
from navtool.datasets.store.schema import Contents
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.sync import Match, choose, nearest
from navtool.datasets.streams.table import row_of
from navtool.datasets.streams.video_survey import VideoSurvey
from navtool.pipeline.arrays import Array


@dataclass(slots=True)
class LargeStream:
    """Images or clouds: which message, counted in the order of record, serves which ticks."""

    topic: str
    record_ns: Int64[Array, " messages"]
    """When each message was recorded, in that order."""
    episode_ticks: dict[int, list[int]]
    """Ticks of the episode that a message serves."""
    stamps_ns: dict[int, int]
    """Time on the grid's clock of every message with a usable stamp, by its position in the order of record."""
    match: Match
    view: PictureView = AS_RECORDED
    """How its pictures are shown."""
    native_size: tuple[int, int] | None = None
    """Width and height of its first picture."""
    video: VideoSurvey | None = None
    """Where its video can be decoded from; None where each message is a picture by itself."""
    kept: Bool[Array, " messages"] | None = None
    """Which messages are this sensor's; None for all."""


def large_streams(
    found: FirstPass, grid: Grid, contents: Contents, sync: SyncConfig, views: Mapping[str, PictureView]
) -> dict[str, LargeStream]:
    """The large streams that are read again: those of the rows, and clouds in any case, which are kept whole."""
    return {
        name: _large(name, stream, grid, sync, views.get(name, AS_RECORDED))
        for name, stream in found.streams.items()
        if name in contents.large or row_of(name).name == "lidar"
    }


def served_columns(
    large: Mapping[str, LargeStream], contents: Contents, ticks_ns: Int64[Array, " ticks"]
) -> dict[str, Column]:
    """Which ticks a large stream of the rows serves, and how far from them its messages lie."""
    nothing: Array = np.array([], dtype=np.int64)
    columns: dict[str, Column] = {}
    for name in contents.large:
        match = large[name].match if name in large else nearest(nothing, ticks_ns, 1.0)
        columns[f"valid.{name}"] = match.valid.copy()
        columns[f"sync.error_s.{name}"] = match.error_s.astype(np.float32)
    return columns


def _large(name: str, stream: RecordedStream, grid: Grid, config: SyncConfig, view: PictureView) -> LargeStream:
    time, sync = grid.times[name], config.of(name)
    if sync is None:
        raise ValueError(f"{name} is not brought onto the grid")
    match = choose(sync.method, time.stamps_ns, grid.ticks_ns, sync.tolerance_s)
    episode_ticks: dict[int, list[int]] = {}
    for tick in np.flatnonzero(match.valid).tolist():
        episode_ticks.setdefault(int(time.order[match.index[tick]]), []).append(tick)
    stamps = dict(zip(time.order.tolist(), time.stamps_ns.tolist(), strict=True))
    return LargeStream(
        stream.topic,
        stream.stamps[1],
        episode_ticks,
        stamps,
        match,
        view,
        stream.native_size,
        _sendable(stream.video),
        stream.kept,
    )


def _sendable(video: VideoSurvey | None) -> VideoSurvey | None:
    return None if video is None else video.without_decoder()
