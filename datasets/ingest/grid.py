"""The grid of an episode: its ticks, and every stream's time on their clock."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64

from navtool.base.errors import DatasetsError
from navtool.datasets.recording import Recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.front_camera import recorded_topic_map
from navtool.datasets.robot.topic_map import TopicMap
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.from_transforms import may_hold_odometry
from navtool.datasets.streams.sync import grid_ticks
from navtool.datasets.streams.table import grid_streams, lone_grid_streams
from navtool.pipeline.arrays import Array

MIN_ROWS = 2
MOST_PAUSE_S = 3600.0
"""Where nothing that could make a grid comes for longer, there are two runs, or a stamp that is wrong."""

_CURE_NOTHING = (
    "a data set needs a camera, a point cloud, odometry, an IMU, joints or a battery; name its topics with --robot FILE"
)


@dataclass(frozen=True, slots=True)
class Grid:
    """The ticks of an episode, and every stream's time on the clock of the one that spans them."""

    stream: str
    """The stream that spans it."""
    times: dict[str, StreamTime]
    ticks_ns: Int64[Array, " ticks"]


def usable_topics(recording: Recording, robot: RobotConfig) -> TopicMap:
    """Which topic feeds which stream.

    Raises:
        DatasetsError: No stream can span a grid.
    """
    topics = recorded_topic_map(robot, recording)
    spanned = grid_streams(topics.streams) or lone_grid_streams(topics.streams)
    if not (spanned or may_hold_odometry(topics, robot)):
        raise _nothing_usable(recording, topics)
    return topics


def lay_grid(recording: Recording, topics: TopicMap, clocks: Clocks, fps: int) -> Grid:
    """The grid of the first stream that spans two ticks: a camera, a LiDAR, odometry; else IMU, joints, battery.

    Raises:
        DatasetsError: None does, or the recording is silent for more than an hour.
    """
    spans = []
    for name in (*grid_streams(clocks.header_ns), *lone_grid_streams(clocks.header_ns)):
        times = clocks.times(name)
        stamps = times[name].stamps_ns
        _refuse_silence(name, times, recording)
        ticks = _from_first_state(grid_ticks(int(stamps[0]), int(stamps[-1]), fps), times.get("odometry"))
        if ticks.size >= MIN_ROWS:
            return Grid(name, times, ticks)
        spans.append(f"{name} spans {(stamps[-1] - stamps[0]) * 1e-9:.3f} s")
    if not spans:
        raise _nothing_usable(recording, topics)
    what = f"{', '.join(spans)}: less than two ticks at {fps} Hz"
    raise DatasetsError(what, where=recording.path, cure="record longer, or raise fps=")


def _refuse_silence(grid_stream: str, times: dict[str, StreamTime], recording: Recording) -> None:
    """A wrong stamp years away would make a grid of years."""
    first_ns, last_ns = times[grid_stream].stamps_ns[[0, -1]]
    alike = lone_grid_streams(times) if grid_stream in lone_grid_streams(times) else grid_streams(times)
    stamps_ns = np.unique(np.concatenate([times[name].stamps_ns for name in alike]))
    stamps_ns = stamps_ns[(stamps_ns >= first_ns) & (stamps_ns <= last_ns)]
    pauses_s = np.diff(stamps_ns) * 1e-9
    if pauses_s.size and pauses_s.max() > MOST_PAUSE_S:
        longest = int(pauses_s.argmax())
        after_s = (stamps_ns[longest] - first_ns) * 1e-9
        raise DatasetsError(
            f"{grid_stream}: silence of {pauses_s[longest]:.0f} s behind {after_s:.3f} s: a stamp is wrong, or these "
            "are two runs",
            where=recording.path,
            cure=f"set sync.{grid_stream}.clock=record if its header stamps are wrong, or split the recording",
        )


def _from_first_state(ticks: Int64[Array, " n"], odometry: StreamTime | None) -> Int64[Array, " m"]:
    """The ticks from the first measured speed on: a row before it would spoil the history of the 49 that follow.

    What was recorded before is counted as outside the grid. An odometry that begins after the last tick has no say.
    """
    if odometry is None or odometry.stamps_ns[0] > ticks[-1]:
        return ticks
    kept: Array = ticks[ticks >= odometry.stamps_ns[0]]
    return kept


def _nothing_usable(recording: Recording, topics: TopicMap) -> DatasetsError:
    return DatasetsError(_what_was_found(recording, topics), where=recording.path, cure=_CURE_NOTHING)


def _what_was_found(recording: Recording, topics: TopicMap) -> str:
    if recording.message_count == 0:
        return "no usable stream: the recording has no messages"
    others = ", ".join(f"{topic.name} ({topic.type}: {topic.reason})" for topic in topics.not_used)
    used = ", ".join(f"{stream} {topic}" for stream, topic in topics.streams.items())
    transforms = ", ".join(topics.transforms)
    parts = [
        f"found {used}" if used else "",
        f"transforms {transforms}" if transforms else "",
        f"not used: {others}" if others else "",
    ]
    parts += recording.faults
    return f"no usable stream: {'; '.join(part for part in parts if part)}"
