"""Second pass over a recording: images and clouds into the rows, the video and the files beside them."""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float32, UInt8

from navtool.datasets.decode.messages import ImageFrame, PointCloud
from navtool.datasets.errors import DatasetsError
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.data_file import DataFile
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.ingest.sidecar import CloudFile, write_streams
from navtool.datasets.ingest.stats import CloudStats, ImageStats, Stats, column_stats
from navtool.datasets.ingest.video import VideoWriter
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.schema import (
    CLOUD_RELIABILITY_KEYS,
    CLOUD_SIZE,
    COUNT_KEY,
    IMAGE_HEIGHT_PX,
    IMAGE_KEY,
    IMAGE_RELIABILITY_KEYS,
    IMAGE_WIDTH_PX,
    POINTS_KEY,
    Feature,
)
from navtool.pipeline.arrays import Array
from navtool.pipeline.cloud_reliability import cloud_reliability
from navtool.pipeline.downsample import fixed_size_cloud
from navtool.pipeline.geometry.transforms import apply_transform
from navtool.pipeline.image_reliability import image_reliability

logger = logging.getLogger(__name__)

type Image = UInt8[Array, "240 320 3"]
type Points = Float32[Array, "10000 3"]


@dataclass(frozen=True, slots=True)
class Numbering:
    """An episode's place in the data set."""

    episode_index: int
    index_from: int
    """Number of rows before it."""


@dataclass(slots=True)
class EpisodeFolder:
    """The staged files of one episode, laid out as they will be in the data set."""

    root: Path
    numbering: Numbering
    rows: int = 0
    stats: dict[str, Stats] = field(default_factory=dict)
    undecodable: dict[str, int] = field(default_factory=dict)
    points_nonfinite: int = 0

    @property
    def data(self) -> Path:
        """The staged data file."""
        return self.root / "data.parquet"

    @property
    def video(self) -> Path:
        """The staged video."""
        return self.root / "video.mp4"

    @property
    def beside(self) -> Path:
        """The staged folder of what LeRobot does not hold."""
        return self.root / "episode"


class _Rows:
    """Collects images and clouds as they were recorded and hands them on in the order of ticks."""

    def __init__(self, plan: EpisodePlan, data: DataFile, video: VideoWriter | None) -> None:
        self._columns = plan.columns
        self._ticks = plan.ticks_ns.size
        self._data, self._video = data, video
        self._waits = {name: stream.match.valid.copy() for name, stream in plan.large.items()}
        self._has = {"image": plan.contents.image, "lidar": plan.contents.lidar}
        self._images: dict[int, Image] = {}
        self._clouds: dict[int, tuple[Points, int]] = {}
        self._next = 0
        self.image_stats, self.cloud_stats = ImageStats(), CloudStats()

    def add_image(self, ticks: list[int], frame: ImageFrame, reliability: tuple[float, float, float]) -> None:
        small: Image = cv2.resize(frame.rgb, (IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX), interpolation=_shrink(frame)).astype(
            np.uint8
        )
        for tick in ticks:
            self._images[tick] = small
            for key, value in zip(IMAGE_RELIABILITY_KEYS, reliability, strict=True):
                self._columns[key][tick] = value
        self._settle("image", ticks)

    def add_cloud(self, ticks: list[int], points: Points, count: int, reliability: tuple[float, float, float]) -> None:
        for tick in ticks:
            self._clouds[tick] = points, count
            self._columns[COUNT_KEY][tick] = count
            for key, value in zip(CLOUD_RELIABILITY_KEYS, reliability, strict=True):
                self._columns[key][tick] = value
        self._settle("lidar", ticks)

    def give_up(self, stream: str, ticks: list[int]) -> None:
        """The message that was to serve these ticks cannot be decoded."""
        self._columns[f"valid.{stream}"][ticks] = False
        self._columns[f"sync.error_s.{stream}"][ticks] = 0.0
        self._settle(stream, ticks)

    def _settle(self, stream: str, ticks: list[int]) -> None:
        self._waits[stream][ticks] = False
        while self._next < self._ticks and not any(waits[self._next] for waits in self._waits.values()):
            self._emit(self._next)
            self._next += 1

    def finish(self) -> None:
        """Hand on what is left; ticks whose message never came are without it."""
        for stream, waits in self._waits.items():
            self.give_up(stream, np.flatnonzero(waits).tolist())
        if not self._waits:
            for tick in range(self._ticks):
                self._emit(tick)

    def _emit(self, tick: int) -> None:
        if self._video is not None:
            image = self._images.pop(tick, None)
            self._video.add(_BLACK if image is None else image)
            if image is not None:
                self.image_stats.add(image)
        points, count = self._clouds.pop(tick, (_NO_POINTS, 0))
        if self._has["lidar"] and count:
            self.cloud_stats.add(points[:count])
        self._data.add(tick, points if self._has["lidar"] else None)


_BLACK: Image = np.zeros((IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX, 3), dtype=np.uint8)
_NO_POINTS: Points = np.zeros((CLOUD_SIZE, 3), dtype=np.float32)


def _shrink(frame: ImageFrame) -> int:
    return cv2.INTER_AREA if frame.rgb.shape[1] > IMAGE_WIDTH_PX else cv2.INTER_LINEAR


def write_episode(
    recording: Recording,
    plan: EpisodePlan,
    features: dict[str, Feature],
    config: IngestConfig,
    folder: EpisodeFolder,
    advance: Callable[[int], None] | None = None,
) -> None:
    """Read the images and clouds of a recording and write the staged files of its episode.

    Reliabilities are computed from the raw frame and the raw cloud, before any resizing, thinning or encoding. A
    message that cannot be decoded leaves its ticks without it and is counted. Memory does not grow with the length.

    Args:
        folder: Where to write; its counts and statistics are filled in.
        advance: Called with the bytes of each message read.
    """
    _add_empty_columns(plan)
    _add_counters(plan, folder.numbering, config.fps)
    write_streams(folder.beside / "streams", plan.small, plan.calibration.base_imu)
    by_topic = {stream.topic: name for name, stream in plan.large.items()}
    with ExitStack() as stack:
        data = stack.enter_context(DataFile(folder.data, features, plan.columns))
        video = stack.enter_context(VideoWriter(folder.video, config.fps)) if plan.contents.image else None
        clouds = stack.enter_context(CloudFile(folder.beside / "clouds.parquet")) if "lidar" in plan.large else None
        rows = _Rows(plan, data, video)
        position = dict.fromkeys(plan.large, 0)
        for raw in recording.messages(tuple(by_topic)) if by_topic else ():
            name = by_topic[raw.topic]
            _add_message(recording, raw, name, position[name], plan, config, rows, clouds, folder)
            position[name] += 1
            if advance is not None:
                advance(len(raw.data))
        rows.finish()
    folder.rows = plan.ticks_ns.size
    _fill_stats(folder, plan, features, rows)


def _add_message(
    recording: Recording,
    raw: RawMessage,
    name: str,
    position: int,
    plan: EpisodePlan,
    config: IngestConfig,
    rows: _Rows,
    clouds: CloudFile | None,
    folder: EpisodeFolder,
) -> None:
    stream = plan.large[name]
    ticks = stream.ticks_of.get(position, [])
    if name == "image" and not ticks:
        return
    try:
        sample = recording.decode(raw)
    except DatasetsError as error:
        logger.debug("%s: %s", raw.topic, error)
        folder.undecodable[name] = folder.undecodable.get(name, 0) + 1
        rows.give_up(name, ticks)
        return
    if isinstance(sample, ImageFrame):
        reliability = image_reliability(sample.rgb, config.image_reliability)
        rows.add_image(ticks, sample, (reliability.image, reliability.brightness, reliability.corners))
    elif isinstance(sample, PointCloud):
        stamp = stream.stamps_ns.get(position, raw.record_ns)
        folder.points_nonfinite += sample.dropped_nonfinite
        if clouds is not None:
            clouds.add(sample, stamp, raw.record_ns, ticks[0] if ticks else -1)
        if ticks:
            trust = cloud_reliability(sample.xyz, sample.ring, config.cloud_reliability)
            points, count = _in_base_frame(sample, plan, stamp, config.voxel_m)
            rows.add_cloud(ticks, points, count, (trust.cloud, trust.edge, trust.planar))


def _in_base_frame(cloud: PointCloud, plan: EpisodePlan, stamp_ns: int, voxel_m: float) -> tuple[Points, int]:
    returned = cloud.xyz[cloud.xyz.any(axis=1)]
    pose = plan.calibration.base_lidar
    xyz = returned if pose is None else apply_transform(pose, returned).astype(np.float32)
    return fixed_size_cloud(xyz, CLOUD_SIZE, stamp_ns, voxel_m)


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


def _fill_stats(folder: EpisodeFolder, plan: EpisodePlan, features: dict[str, Feature], rows: _Rows) -> None:
    for key, feature in features.items():
        if key == IMAGE_KEY:
            folder.stats[key] = rows.image_stats.result()
        elif key == POINTS_KEY:
            folder.stats[key] = rows.cloud_stats.result()
        elif feature.dtype != "string":
            folder.stats[key] = column_stats(plan.columns[key])
