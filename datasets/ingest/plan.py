"""What an episode will be, known after the first pass: its grid, its small columns, who serves which tick."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Int64

from navtool.base.errors import DatasetsError
from navtool.datasets.ingest.columns import small_columns
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.sync_report import sync_report
from navtool.datasets.recording import Recording
from navtool.datasets.robot.calibration import Calibration, calibrate
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.gravity import odd_gravity
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, latest_transforms
from navtool.datasets.robot.topic_map import TopicMap, resolve_topic_map
from navtool.datasets.store.data_file import Column
from navtool.datasets.store.schema import Contents
from navtool.datasets.store.sidecar import write_streams
from navtool.datasets.streams.align import in_base_axes
from navtool.datasets.streams.battery_sign import discharge_sign
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.config import StreamSync
from navtool.datasets.streams.motion import Motion
from navtool.datasets.streams.odometry_heading import heading_notes, turned_odometry
from navtool.datasets.streams.scan import LARGE, Scan, StreamScan, scan_recording
from navtool.datasets.streams.sync import Match, choose, grid_ticks, nearest
from navtool.datasets.streams.timed_stream import TimedStream, motion_of
from navtool.pipeline.arrays import Array

GRID_STREAMS = ("image", "lidar", "odometry")
"""The first of these that lasts for two ticks spans the grid."""
MIN_ROWS = 2
MOST_PAUSE_S = 3600.0
"""Where nothing that could make a grid comes for longer, there are two runs, or a stamp that is wrong."""


@dataclass(slots=True)
class LargeStream:
    """Images or clouds: which message, counted in the order of record, serves which ticks."""

    topic: str
    record_ns: Int64[Array, " messages"]
    """When each message was recorded, in that order."""
    ticks_of: dict[int, list[int]]
    stamps_ns: dict[int, int]
    """Time on the grid's clock of every message with a usable stamp, by its position in the order of record."""
    match: Match


@dataclass(slots=True)
class EpisodePlan:
    """One recording's episode before its images and clouds are read."""

    topics: TopicMap
    found: Contents
    """What the recording has."""
    contents: Contents
    """What the data set has."""
    ticks_ns: Int64[Array, " ticks"]
    columns: dict[str, Column]
    large: dict[str, LargeStream]
    motion: Motion | None
    """By which clouds are compensated; None where that is not wanted or there is no odometry."""
    calibration: Calibration
    recording_start_ns: int
    """When the recording began, on the grid's clock; events are counted from it."""
    sync_report: dict[str, object]
    dropped: dict[str, int]
    notes: list[str]
    faults: tuple[str, ...]
    """What is wrong with the recording's files; empty for sound ones."""


def plan_episode(
    recording: Recording,
    robot: RobotConfig,
    config: IngestConfig,
    fixed: Contents | None,
    streams_to: Path | None = None,
    reached: Callable[[int], None] | None = None,
) -> EpisodePlan:
    """Read the recording once and lay its episode out on the grid.

    Args:
        fixed: Contents of the data set that the episode joins; None for the first one, whose contents it fixes.
        streams_to: Where to write the small streams at their own rates; None writes nothing.
        reached: Called with the record time of each message read.

    Raises:
        DatasetsError: If the recording has no stream that can span a grid, less than two ticks of it, or is silent for
            more than an hour.
    """
    topics = resolve_topic_map(robot.topics, recording.topics)
    if not any(getattr(topics, stream) for stream in GRID_STREAMS):
        raise DatasetsError(_nothing_usable(recording, topics), where=recording.path, cure=_CURE_NOTHING)
    joint_names = fixed.joint_names if fixed is not None else tuple(robot.joint_names)
    scan = scan_recording(recording, topics, joint_names, robot.joy, reached)
    clocks = Clocks.of(scan, config)
    grid_stream, times, ticks = _grid(recording, topics, scan, clocks, config.fps)
    found = _contents(scan)
    contents = fixed or found
    transforms, changed = latest_transforms(scan.transforms)
    calibration = calibrate(
        robot,
        RecordedGeometry(
            {name: stream.frame_id for name, stream in scan.streams.items()}, transforms, scan.camera_info
        ),
        image_topic=topics.image,
        native_size=scan.streams["image"].native_size if "image" in scan.streams else None,
    )
    recorded = {name: TimedStream.of(stream, times[name]) for name, stream in scan.streams.items() if name not in LARGE}
    small = in_base_axes(recorded, calibration)
    if "odometry" in small:
        small["odometry"] = turned_odometry(small["odometry"], robot.odometry_yaw_rad)
    discharge = discharge_sign(robot.battery_current_sign, small.get("battery"))
    columns = small_columns(ticks, small, contents, config.sync, discharge.sign)
    large = {
        name: _large(scan.streams[name], times[name], ticks, config.sync.gridded()[name])
        for name in LARGE
        # Clouds are kept whole beside the rows, also where the rows have none.
        if name in scan.streams and (getattr(contents, name) or name == "lidar")
    }
    for name in LARGE:
        if getattr(contents, name):
            match = large[name].match if name in large else nearest(np.array([], dtype=np.int64), ticks, 1.0)
            columns.values[f"valid.{name}"] = match.valid.copy()
            columns.values[f"sync.error_s.{name}"] = match.error_s.astype(np.float32)
    if streams_to is not None:
        write_streams(streams_to, small)
    notes = [
        *(f"recovered: {fault}" for fault in recording.faults),
        *topics.notes,
        *(
            f"{name}: {stream.beyond_measure} values are infinite or beyond 1e15: not measured"
            for name, stream in scan.streams.items()
            if stream.beyond_measure
        ),
        *columns.notes,
        *discharge.notes,
        *heading_notes(small.get("odometry")),
        *_calibration_notes(scan, calibration),
        *(f"tf_static: {pair} was published with different values; the last one counts" for pair in changed),
    ]
    if "imu" in small and (odd := odd_gravity(small["imu"].columns("ax_mps2", "ay_mps2", "az_mps2"))):
        notes.append(f"imu: {odd}")
    notes += [
        f"{name}: not one of {stream.undecodable} messages on {stream.topic} can be decoded: {stream.first_fault}"
        for name, stream in scan.unreadable.items()
    ]
    if config.deskew and "odometry" not in small and "lidar" in large:
        notes.append("lidar: no odometry to compensate the robot's motion with; points stay as measured")
    return EpisodePlan(
        topics=topics,
        found=found,
        contents=contents,
        ticks_ns=ticks,
        columns=columns.values,
        large=large,
        motion=motion_of(small.get("odometry"), config.sync.odometry.tolerance_s) if config.deskew else None,
        calibration=calibration,
        recording_start_ns=clocks.on_clock_of(grid_stream, recording.start_ns),
        sync_report=sync_report(scan, clocks, times, grid_stream, ticks, columns.values, config.sync),
        dropped=_dropped(scan, times, {name: x for name, x in large.items() if getattr(contents, name)}, ticks),
        notes=notes,
        faults=recording.faults,
    )


_CURE_NOTHING = "a data set needs a camera, a point cloud or odometry; name its topics with --robot FILE"


def _nothing_usable(recording: Recording, topics: TopicMap) -> str:
    if recording.message_count == 0:
        return "no usable stream: the recording has no messages"
    others = ", ".join(f"{topic.name} ({topic.type}: {topic.reason})" for topic in topics.not_used)
    used = ", ".join(f"{stream} {topic}" for stream, topic in topics.streams().items())
    transforms = ", ".join(topics.transforms)
    parts = [
        f"found {used}" if used else "",
        f"transforms {transforms}" if transforms else "",
        f"not used: {others}" if others else "",
    ]
    parts += recording.faults
    return f"no usable stream: {'; '.join(part for part in parts if part)}"


def _grid(
    recording: Recording, topics: TopicMap, scan: Scan, clocks: Clocks, fps: int
) -> tuple[str, dict[str, StreamTime], Int64[Array, " ticks"]]:
    """The first stream that spans two ticks, every stream's time on its clock, and the ticks."""
    spans = []
    for name in GRID_STREAMS:
        if name in scan.streams:
            times = clocks.times(name)
            stamps = times[name].stamps_ns
            _refuse_silence(name, times, recording)
            ticks = _from_first_state(grid_ticks(int(stamps[0]), int(stamps[-1]), fps), times.get("odometry"))
            if ticks.size >= MIN_ROWS:
                return name, times, ticks
            spans.append(f"{name} spans {(stamps[-1] - stamps[0]) * 1e-9:.3f} s")
    if not spans:
        raise DatasetsError(_nothing_usable(recording, topics), where=recording.path, cure=_CURE_NOTHING)
    what = f"{', '.join(spans)}: less than two ticks at {fps} Hz"
    raise DatasetsError(what, where=recording.path, cure="record longer, or raise fps=")


def _refuse_silence(grid_stream: str, times: dict[str, StreamTime], recording: Recording) -> None:
    """A wrong stamp years away would make a grid of years."""
    first_ns, last_ns = times[grid_stream].stamps_ns[[0, -1]]
    stamps_ns = np.unique(np.concatenate([times[name].stamps_ns for name in GRID_STREAMS if name in times]))
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


def _contents(scan: Scan) -> Contents:
    joints = scan.streams.get("joints")
    return Contents(
        image="image" in scan.streams,
        lidar="lidar" in scan.streams,
        imu="imu" in scan.streams,
        joint_names=joints.joint_names if joints is not None else (),
        battery="battery" in scan.streams,
    )


def _large(stream: StreamScan, time: StreamTime, ticks: Int64[Array, " ticks"], sync: StreamSync) -> LargeStream:
    match = choose(sync.method, time.stamps_ns, ticks, sync.tolerance_s)
    ticks_of: dict[int, list[int]] = {}
    for tick in np.flatnonzero(match.valid).tolist():
        ticks_of.setdefault(int(time.order[match.index[tick]]), []).append(tick)
    stamps = dict(zip(time.order.tolist(), time.stamps_ns.tolist(), strict=True))
    return LargeStream(stream.topic, stream.stamps[1], ticks_of, stamps, match)


def _calibration_notes(scan: Scan, calibration: Calibration) -> list[str]:
    notes = [f"{topic}: cannot be used: {fault}" for topic, fault in scan.faults.items()]
    if "image" in scan.streams and calibration.camera is None:
        notes.append("camera: no CameraInfo and none in the robot's configuration; trajectory images cannot be made")
    for sensor, pose in (
        ("image", calibration.base_camera),
        ("lidar", calibration.base_lidar),
        ("imu", calibration.base_imu),
        ("odometry", calibration.base_odometry),
    ):
        stated = sensor != "odometry" or bool(scan.streams[sensor].frame_id) if sensor in scan.streams else False
        if stated and pose is None:
            frame = scan.streams[sensor].frame_id or "(none)"
            kept = "its pose stays unknown" if sensor == "image" else "its axes are taken for the base frame's"
            notes.append(f"{sensor}: no transform from the base frame to {frame} and no mounting configured; {kept}")
    return notes


def _dropped(
    scan: Scan, times: dict[str, StreamTime], large: dict[str, LargeStream], ticks: Int64[Array, " ticks"]
) -> dict[str, int]:
    """Counts of messages that reach no row, by reason; the native streams and clouds keep them all the same."""
    counts: dict[str, int] = {}
    for name, stream in large.items():
        inside = [n for n, stamp in stream.stamps_ns.items() if ticks[0] <= stamp <= ticks[-1]]
        counts[f"{name}: outside the grid"] = len(stream.stamps_ns) - len(inside)
        counts[f"{name}: another message is nearer to the tick"] = sum(n not in stream.ticks_of for n in inside)
    for name, time in times.items():
        counts[f"{name}: stamp repeated"] = time.repeated
        counts[f"{name}: no stamp"] = time.unstamped
        if name not in LARGE:
            counts[f"{name}: cannot be decoded"] = scan.streams[name].undecodable
    counts |= {f"{name}: cannot be decoded": stream.undecodable for name, stream in scan.unreadable.items()}
    return {reason: count for reason, count in counts.items() if count}
