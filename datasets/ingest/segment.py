"""Second pass over a recording, one segment of it: images and clouds read, judged, thinned and written.

A segment is a fixed number of ticks, so that the same recording is cut alike whoever works on it: one process after
another or several at a time. What a segment writes is joined by ``assemble``.
"""

import logging
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Bool, Float32, Float64, Shaped, UInt8

from navtool.datasets.decode.messages import ImageFrame, PointCloud
from navtool.datasets.errors import DatasetsError
from navtool.datasets.ingest.background import Background
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.motion import Motion
from navtool.datasets.ingest.plan import EpisodePlan, LargeStream
from navtool.datasets.ingest.sidecar import CloudFile
from navtool.datasets.ingest.stats import CloudStats, ImageStats
from navtool.datasets.ingest.video import VideoWriter
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.schema import (
    CLOUD_RELIABILITY_KEYS,
    CLOUD_SIZE,
    COUNT_KEY,
    IMAGE_HEIGHT_PX,
    IMAGE_RELIABILITY_KEYS,
    IMAGE_WIDTH_PX,
)
from navtool.pipeline.arrays import Array
from navtool.pipeline.cloud_reliability import cloud_reliability
from navtool.pipeline.downsample import fixed_size_cloud
from navtool.pipeline.geometry.deskew import deskewed
from navtool.pipeline.image_reliability import image_reliability

logger = logging.getLogger(__name__)

TICKS_PER_SEGMENT = 512
"""A multiple of the rows of a row group, so that none spans two segments."""

_KNOTS = 17
"""Moments of a sweep for which the robot's pose is taken from odometry."""
_SWEEP_NS = 1_000_000_000
"""No sweep lasts longer."""

type Image = UInt8[Array, "240 320 3"]
type Points = Float32[Array, "10000 3"]


@dataclass(frozen=True, slots=True)
class StreamPart:
    """What a segment reads of images or clouds; messages are numbered by their position in the order of record."""

    topic: str
    first: int
    """Position of the first message of the segment's portion of the recording."""
    ticks_of: dict[int, list[int]]
    """Ticks, counted from the segment's first one, that a message serves."""
    own: frozenset[int]
    """Messages that belong to this segment and no other, whether they serve a tick or not."""
    stamps_ns: dict[int, int]
    """Time on the grid's clock of all of these."""


@dataclass(frozen=True, slots=True)
class Segment:
    """A fixed number of ticks of an episode, and the portion of the recording that serves them."""

    number: int
    first_tick: int
    ticks: int
    start_ns: int
    """Record time of the first message to read."""
    end_ns: int
    """Record time of the last one."""
    parts: dict[str, StreamPart]
    image: bool
    lidar: bool
    base_lidar: Float64[Array, "4 4"] | None
    motion: Motion | None
    """The robot's motion in this portion, by which its clouds are compensated; None leaves them as measured."""


@dataclass(slots=True)
class SegmentResult:
    """What a segment found; its files lie in the episode's staged folder."""

    columns: dict[str, Shaped[Array, " ticks"]]
    """Reliabilities and counts."""
    lost: dict[str, list[int]] = field(default_factory=dict)
    """Ticks, by stream, whose message cannot be decoded or never came."""
    undecodable: dict[str, int] = field(default_factory=dict)
    points_nonfinite: int = 0
    not_deskewed: int = 0
    """Clouds that were to be compensated for the robot's motion and could not be."""
    images: ImageStats = field(default_factory=ImageStats)
    clouds: CloudStats = field(default_factory=CloudStats)


def video_part(folder: Path, segment: int) -> Path:
    """The segment's frames as a video."""
    return folder / f"video-{segment:05d}.mp4"


def points_part(folder: Path, segment: int) -> Path:
    """The segment's clouds of fixed size: float32, (ticks, 10000, 3), nothing else."""
    return folder / f"points-{segment:05d}.f32"


def clouds_part(folder: Path, segment: int) -> Path:
    """The whole clouds of the segment's portion of the recording."""
    return folder / "episode" / "clouds" / f"part-{segment:05d}.parquet"


def cut_segments(plan: EpisodePlan) -> list[Segment]:
    """The segments of an episode; none where it has neither images nor clouds."""
    if not (plan.contents.image or plan.contents.lidar):
        return []
    total = int(plan.ticks_ns.size)
    count = -(-total // TICKS_PER_SEGMENT)
    parts = {name: _cut(stream, count) for name, stream in plan.large.items()}
    return [
        _segment(plan, number, min(TICKS_PER_SEGMENT, total - number * TICKS_PER_SEGMENT), parts)
        for number in range(count)
    ]


def _segment(
    plan: EpisodePlan, number: int, ticks: int, parts: dict[str, list[tuple[list[int], list[int]]]]
) -> Segment:
    first_tick = number * TICKS_PER_SEGMENT
    needed = {name: sorted({*cut[number][0], *cut[number][1]}) for name, cut in parts.items()}
    spans = [
        (int(plan.large[name].record_ns[positions[0]]), int(plan.large[name].record_ns[positions[-1]]))
        for name, positions in needed.items()
        if positions
    ]
    start_ns, end_ns = (min(a for a, _ in spans), max(b for _, b in spans)) if spans else (0, -1)
    return Segment(
        number=number,
        first_tick=first_tick,
        ticks=ticks,
        start_ns=start_ns,
        end_ns=end_ns,
        parts={name: _part(plan.large[name], start_ns, first_tick, ticks, *cut[number]) for name, cut in parts.items()},
        image=plan.contents.image,
        lidar=plan.contents.lidar,
        base_lidar=plan.calibration.base_lidar,
        motion=None if plan.motion is None else _motion(plan.motion, plan.large.get("lidar"), needed.get("lidar", [])),
    )


def _motion(motion: Motion, clouds: LargeStream | None, positions: list[int]) -> Motion | None:
    stamps = [] if clouds is None else [clouds.stamps_ns[p] for p in positions if p in clouds.stamps_ns]
    return motion.between(min(stamps) - _SWEEP_NS, max(stamps) + _SWEEP_NS) if stamps else None


def _cut(stream: LargeStream, count: int) -> list[tuple[list[int], list[int]]]:
    """For each segment the positions that serve its ticks, and those that belong to it alone.

    A message belongs to the segment of the first tick it serves; one that serves none to that of the messages recorded
    before it.
    """
    serving: list[list[int]] = [[] for _ in range(count)]
    home: Array = np.zeros(stream.record_ns.size, dtype=np.int64)
    for position, ticks in stream.ticks_of.items():
        home[position] = ticks[0] // TICKS_PER_SEGMENT
        for segment in dict.fromkeys(tick // TICKS_PER_SEGMENT for tick in ticks):
            serving[segment].append(position)
    home = np.maximum.accumulate(home)
    return [(serving[segment], np.flatnonzero(home == segment).tolist()) for segment in range(count)]


def _part(
    stream: LargeStream, start_ns: int, first_tick: int, ticks: int, serving: list[int], own: list[int]
) -> StreamPart:
    inside = range(first_tick, first_tick + ticks)
    return StreamPart(
        topic=stream.topic,
        first=int(np.searchsorted(stream.record_ns, start_ns)),
        ticks_of={p: [tick - first_tick for tick in stream.ticks_of[p] if tick in inside] for p in serving},
        own=frozenset(own),
        stamps_ns={p: stream.stamps_ns.get(p, int(stream.record_ns[p])) for p in {*serving, *own}},
    )


def write_segment(
    recording: Recording,
    segment: Segment,
    config: IngestConfig,
    folder: Path,
    advance: Callable[[int], None] | None = None,
) -> SegmentResult:
    """Read a segment's images and clouds and write its parts of the episode's files.

    Reliabilities are computed from the raw frame and the raw cloud, before any resizing, thinning or encoding. A
    message that cannot be decoded leaves its ticks without it and is counted. Memory does not grow with the length.

    Args:
        folder: The episode's staged folder.
        advance: Called with the bytes of each message read.
    """
    by_topic = {part.topic: name for name, part in segment.parts.items()}
    position = {name: part.first for name, part in segment.parts.items()}
    with ExitStack() as stack:
        rows = _Rows(segment, config, folder, stack)
        if by_topic and segment.end_ns >= segment.start_ns:
            for raw in recording.messages(tuple(by_topic), segment.start_ns, segment.end_ns):
                name = by_topic[raw.topic]
                rows.take(recording, raw, name, position[name])
                position[name] += 1
                if advance is not None:
                    advance(len(raw.data))
        rows.finish()
    return rows.result


class _Rows:
    """Takes messages as they were recorded and writes rows in the order of ticks."""

    def __init__(self, segment: Segment, config: IngestConfig, folder: Path, stack: ExitStack) -> None:
        self._segment, self._config = segment, config
        folder.mkdir(parents=True, exist_ok=True)
        self._video = (
            stack.enter_context(VideoWriter(video_part(folder, segment.number), config.fps)) if segment.image else None
        )
        self._points = stack.enter_context(points_part(folder, segment.number).open("wb")) if segment.lidar else None
        self._clouds = (
            stack.enter_context(CloudFile(clouds_part(folder, segment.number))) if "lidar" in segment.parts else None
        )
        keys = [*(IMAGE_RELIABILITY_KEYS if segment.image else ()), *(CLOUD_RELIABILITY_KEYS if segment.lidar else ())]
        self.result = SegmentResult({key: np.zeros(segment.ticks, dtype=np.float32) for key in keys})
        if segment.lidar:
            self.result.columns[COUNT_KEY] = np.zeros(segment.ticks, dtype=np.int64)
        # Entered last, so left first: nothing is closed while it is still written to.
        self._background = stack.enter_context(Background())
        self._waits = {name: self._served(part) for name, part in segment.parts.items()}
        self._frames: dict[int, Image] = {}
        self._thinned: dict[int, tuple[Points, int]] = {}
        self._next = 0

    def take(self, recording: Recording, raw: RawMessage, name: str, position: int) -> None:
        """Use a message of the portion for its ticks, and a cloud for the file of whole clouds."""
        part = self._segment.parts[name]
        ticks = part.ticks_of.get(position, [])
        if not ticks and (name == "image" or position not in part.own):
            return
        try:
            sample = recording.decode(raw)
        except DatasetsError as error:
            logger.debug("%s: %s", raw.topic, error)
            if position in part.own:
                self.result.undecodable[name] = self.result.undecodable.get(name, 0) + 1
            self._give_up(name, ticks)
            return
        if isinstance(sample, ImageFrame):
            self._add_image(ticks, sample)
        elif isinstance(sample, PointCloud):
            self._add_cloud(ticks, sample, raw, position)

    def finish(self) -> None:
        """Write what is left; ticks whose message never came are without it."""
        for name, waits in self._waits.items():
            self._give_up(name, np.flatnonzero(waits).tolist())
        self._settle()

    def _served(self, part: StreamPart) -> Bool[Array, " ticks"]:
        waits = np.zeros(self._segment.ticks, dtype=np.bool_)
        waits[[tick for ticks in part.ticks_of.values() for tick in ticks]] = True
        return waits

    def _add_image(self, ticks: list[int], frame: ImageFrame) -> None:
        small: Image = cv2.resize(frame.rgb, (IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX), interpolation=_shrink(frame)).astype(
            np.uint8, copy=False
        )
        self._judge(IMAGE_RELIABILITY_KEYS, ticks, image_reliability(frame.rgb, self._config.image_reliability))
        for tick in ticks:
            self._frames[tick] = small
        self._waits["image"][ticks] = False
        self._settle()

    def _add_cloud(self, ticks: list[int], cloud: PointCloud, raw: RawMessage, position: int) -> None:
        part = self._segment.parts["lidar"]
        stamp_ns = part.stamps_ns[position]
        if position in part.own and self._clouds is not None:
            self.result.points_nonfinite += cloud.dropped_nonfinite
            serves = self._segment.first_tick + ticks[0] if ticks else -1
            self._background.call(self._clouds.add, cloud, stamp_ns, raw.record_ns, serves)
        if not ticks:
            return
        self._judge(
            CLOUD_RELIABILITY_KEYS, ticks, cloud_reliability(cloud.xyz, cloud.ring, self._config.cloud_reliability)
        )
        points, kept = self._in_base_frame(cloud, stamp_ns)
        for tick in ticks:
            self._thinned[tick] = points, kept
        self.result.columns[COUNT_KEY][ticks] = kept
        self._waits["lidar"][ticks] = False
        self._settle()

    def _in_base_frame(self, cloud: PointCloud, stamp_ns: int) -> tuple[Points, int]:
        columns = np.ascontiguousarray(cloud.xyz.T)
        time_s = cloud.time_s
        x, y, z = columns
        returned = (x != 0) | (y != 0) | (z != 0)
        if not returned.all():
            columns = columns.compress(returned, axis=1)
            time_s = None if time_s is None else time_s[returned]
        pose = self._segment.base_lidar
        if pose is not None:
            columns = pose[:3, :3].astype(np.float32) @ columns + pose[:3, 3:].astype(np.float32)
        if self._config.deskew:
            columns = self._deskewed(columns, time_s, stamp_ns)
        return fixed_size_cloud(columns.T, CLOUD_SIZE, stamp_ns, self._config.voxel_m)

    def _deskewed(
        self, columns: Float32[Array, "3 n"], time_s: Float32[Array, " n"] | None, stamp_ns: int
    ) -> Float32[Array, "3 n"]:
        motion = self._segment.motion
        if time_s is not None and motion is not None and time_s.size:
            knots = np.linspace(float(time_s.min()), float(time_s.max()) + 1e-6, _KNOTS)
            poses = motion.relative_to(stamp_ns, stamp_ns + np.rint(knots * 1e9).astype(np.int64))
            if poses is not None:
                return deskewed(columns, time_s, knots, poses)
        self.result.not_deskewed += 1
        return columns

    def _judge(self, keys: tuple[str, ...], ticks: list[int], values: tuple[float, ...]) -> None:
        for key, value in zip(keys, values, strict=True):
            self.result.columns[key][ticks] = value

    def _give_up(self, name: str, ticks: list[int]) -> None:
        """The message that was to serve these ticks cannot be used."""
        if ticks:
            self.result.lost.setdefault(name, []).extend(ticks)
            self._waits[name][ticks] = False
            self._settle()

    def _settle(self) -> None:
        """Write every row that waits for nothing more."""
        while self._next < self._segment.ticks and not any(waits[self._next] for waits in self._waits.values()):
            frame = self._frames.pop(self._next, None)
            self._background.call(self._write, frame, *self._thinned.pop(self._next, (_NO_POINTS, 0)))
            self._next += 1

    def _write(self, frame: Image | None, points: Points, kept: int) -> None:
        if self._video is not None:
            self._video.add(_BLACK if frame is None else frame)
            if frame is not None:
                self.result.images.add(frame)
        if self._points is not None:
            self._points.write(points.data)
            if kept:
                self.result.clouds.add(points[:kept])


_BLACK: Image = np.zeros((IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX, 3), dtype=np.uint8)
_NO_POINTS: Points = np.zeros((CLOUD_SIZE, 3), dtype=np.float32)


def _shrink(frame: ImageFrame) -> int:
    return cv2.INTER_AREA if frame.rgb.shape[1] > IMAGE_WIDTH_PX else cv2.INTER_LINEAR
