"""The segments of an episode: fixed numbers of ticks, each with the portion of the recording that serves them.

The same recording is cut alike whoever works on it: one process after another or several at a time.
"""

from bisect import bisect_right
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Int64, Shaped

from navtool.datasets.decode.picture_view import AS_RECORDED, PictureView
from navtool.datasets.ingest.large_stream import LargeStream
from navtool.datasets.ingest.odd_messages import OddMessages
from navtool.datasets.ingest.plan import EpisodePlan
from navtool.datasets.store.row_points import ROWS_PER_PART, points_part
from navtool.datasets.store.stats import ImageStats
from navtool.datasets.streams.motion import Motion
from navtool.datasets.streams.table import of_kind, sensor_of
from navtool.datasets.streams.video_survey import VideoSurvey
from navtool.pipeline.arrays import Array

TICKS_PER_SEGMENT = ROWS_PER_PART
"""A segment writes a file of the rows' points whole."""

_HELD_SEGMENTS = 4
"""A picture that is further away than so many segments is not fetched: the rows of a camera that failed are black."""
_SWEEP_NS = 1_000_000_000
"""No sweep lasts longer."""


@dataclass(frozen=True, slots=True)
class VideoPart:
    """Which packets of a video a segment decodes: those that its pictures need too."""

    first: int
    """Position of the key frame that decoding begins with."""
    last: int
    """Position of the last packet whose picture is wanted."""
    parameters: dict[int, bytes]
    """Parameter sets for key frames whose packets have none, by position."""


@dataclass(frozen=True, slots=True)
class StreamPart:
    """What a segment reads of images or clouds; messages are numbered by their position in the order of record."""

    topic: str
    first: int
    """Position of the first message of the segment's portion of the recording."""
    record_ns: Int64[Array, " portion"]
    """When the messages of that portion were recorded, as the first pass saw it."""
    segment_ticks: dict[int, list[int]]
    """Ticks that a message serves, counted from the segment's first one."""
    own: frozenset[int]
    """Messages that belong to this segment and no other, whether they serve a tick or not."""
    stamps_ns: dict[int, int]
    """Time on the grid's clock of all of these."""
    view: PictureView = AS_RECORDED
    native_size: tuple[int, int] | None = None
    video: VideoPart | None = None


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
    in_rows: tuple[str, ...]
    """Streams of images and clouds that the rows have."""
    base_lidar: Float64[Array, "4 4"] | None
    sound: bool
    """Whether the first pass read the recording through without a fault."""
    motion: Motion | None
    """The robot's motion in this portion, by which its clouds are compensated; None leaves them as measured."""


@dataclass(slots=True)
class SegmentResult:
    """What a segment found; its files lie in the episode's staged folder."""

    columns: dict[str, Shaped[Array, " ticks"]] = field(default_factory=dict)
    """Reliabilities and counts."""
    lost: dict[str, list[int]] = field(default_factory=dict)
    """Ticks, by stream, whose message cannot be decoded or never came."""
    undecodable: dict[str, int] = field(default_factory=dict)
    points_nonfinite: dict[str, int] = field(default_factory=dict)
    """Points, by LiDAR, that were dropped since their coordinates are not finite."""
    not_deskewed: int = 0
    """Clouds that were to be compensated for the robot's motion and could not be."""
    images: dict[str, ImageStats] = field(default_factory=dict)
    """By camera."""
    odd: list[OddMessages] = field(default_factory=list)
    """What was odd about its messages, by lane and recording."""


def video_part(folder: Path, stream: str, segment: int) -> Path:
    """The segment's images of a camera as a video."""
    return folder / f"{stream}-{segment:05d}.mp4"


def row_points_part(folder: Path, segment: int) -> Path:
    """The points of the segment's rows."""
    return points_part(folder / "episode" / "points", segment)


def clouds_part(folder: Path, stream: str, segment: int) -> Path:
    """The whole clouds of a LiDAR in the segment's portion of the recording."""
    return folder / "episode" / "clouds" / sensor_of(stream) / f"part-{segment:05d}.parquet"


def cut_segments(plan: EpisodePlan) -> list[Segment]:
    """The segments of an episode; none where neither its rows nor its recording have images or clouds."""
    if not (plan.large or plan.contents.large):
        return []
    total = int(plan.ticks_ns.size)
    count = -(-total // TICKS_PER_SEGMENT)
    parts = {name: _cut(stream, count) for name, stream in plan.large.items()}
    for name in of_kind("camera", parts):
        _add_held(plan.large[name], parts[name])
    return [
        _segment(plan, number, min(TICKS_PER_SEGMENT, total - number * TICKS_PER_SEGMENT), parts)
        for number in range(count)
    ]


def _segment(
    plan: EpisodePlan, number: int, ticks: int, parts: dict[str, list[tuple[list[int], list[int]]]]
) -> Segment:
    first_tick = number * TICKS_PER_SEGMENT
    needed = {name: _needed(plan.large[name].video, *cut[number]) for name, cut in parts.items()}
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
        parts={
            name: _part(plan.large[name], (start_ns, end_ns), first_tick, ticks, *cut[number])
            for name, cut in parts.items()
        },
        in_rows=plan.contents.large,
        base_lidar=plan.calibration.base_lidar,
        sound=not plan.faults,
        motion=None if plan.motion is None else _motion(plan.motion, plan.large.get("lidar"), needed.get("lidar", [])),
    )


def _needed(video: VideoSurvey | None, serving: list[int], own: list[int]) -> list[int]:
    """Positions of the messages that are read, of a video those from the key frame on that the first one needs."""
    positions = sorted({*serving, *own})
    if video is None or not positions:
        return positions
    return sorted({video.start_for(positions[0]), *positions})


def _video_part(video: VideoSurvey | None, positions: list[int]) -> VideoPart | None:
    if video is None or not positions:
        return None
    first, last = video.start_for(positions[0]), positions[-1]
    return VideoPart(first, last, {key: sets for key, sets in video.parameters.items() if first <= key <= last})


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
    for position, ticks in stream.episode_ticks.items():
        home[position] = ticks[0] // TICKS_PER_SEGMENT
        for segment in dict.fromkeys(tick // TICKS_PER_SEGMENT for tick in ticks):
            serving[segment].append(position)
    home = np.maximum.accumulate(home)
    if stream.kept is not None:
        home[~stream.kept] = -1
    return [(serving[segment], np.flatnonzero(home == segment).tolist()) for segment in range(count)]


def _add_held(stream: LargeStream, parts: list[tuple[list[int], list[int]]]) -> None:
    """Let a segment whose first ticks have no picture read the one before, or else the next one, which stands there."""
    served = sorted((tick, position) for position, ticks in stream.episode_ticks.items() for tick in ticks)
    ticks = [tick for tick, _ in served]
    for segment, (serving, _) in enumerate(parts):
        first = segment * TICKS_PER_SEGMENT
        at = bisect_right(ticks, first) - 1
        if served and not (at >= 0 and ticks[at] == first):
            tick, position = served[max(at, 0)]
            if abs(tick - first) < _HELD_SEGMENTS * TICKS_PER_SEGMENT and position not in serving:
                serving.append(position)


def _part(
    stream: LargeStream, span_ns: tuple[int, int], first_tick: int, ticks: int, serving: list[int], own: list[int]
) -> StreamPart:
    inside = range(first_tick, first_tick + ticks)
    first, end = np.searchsorted(stream.record_ns, span_ns[0]), np.searchsorted(stream.record_ns, span_ns[1], "right")
    return StreamPart(
        topic=stream.topic,
        first=int(first),
        record_ns=stream.record_ns[first:end],
        segment_ticks={p: [tick - first_tick for tick in stream.episode_ticks[p] if tick in inside] for p in serving},
        own=frozenset(own),
        stamps_ns={p: stream.stamps_ns.get(p, int(stream.record_ns[p])) for p in {*serving, *own}},
        view=stream.view,
        native_size=stream.native_size,
        video=_video_part(stream.video, sorted({*serving, *own})),
    )
