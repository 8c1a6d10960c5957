"""What an episode will be, known after the first pass: its grid, its small columns, who serves which tick."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from jaxtyping import Int64

from navtool.base.note import Note
from navtool.datasets.ingest.columns import small_columns
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.ingest.contents import contents_of, contents_to_be
from navtool.datasets.ingest.dropped import dropped_messages
from navtool.datasets.ingest.grid import lay_grid, usable_topics
from navtool.datasets.ingest.large_stream import LargeStream, large_streams, served_columns
from navtool.datasets.ingest.odd_messages import OddMessages, odd_of_first_pass
from navtool.datasets.ingest.plan_notes import (
    deskew_notes,
    geometry_notes,
    gravity_notes,
    held_notes,
    overrule_notes,
    stream_faults,
)
from navtool.datasets.ingest.sync_report import sync_report, time_notes
from navtool.datasets.recording import Recording
from navtool.datasets.robot.calibration import Calibration, CameraImages, calibrate
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, latest_transforms
from navtool.datasets.robot.topic_map import TopicMap
from navtool.datasets.store.data_file import Column
from navtool.datasets.store.schema import IMAGE_HEIGHT_PX, IMAGE_WIDTH_PX, Contents
from navtool.datasets.store.sidecar import write_streams
from navtool.datasets.streams.battery_sign import discharge_sign
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.first_pass import FirstPass, first_pass, refuse_unreadable
from navtool.datasets.streams.flag_sense import with_flag_sense
from navtool.datasets.streams.found_notes import level_notes, picture_views, unreadable_notes
from navtool.datasets.streams.from_transforms import add_from_transforms
from navtool.datasets.streams.measured_offsets import measure_offsets
from navtool.datasets.streams.motion import Motion
from navtool.datasets.streams.small_streams import small_streams
from navtool.datasets.streams.table import grid_streams, lone_grid_streams, of_kind, sensor_of
from navtool.datasets.streams.timed_stream import motion_of
from navtool.pipeline.arrays import Array


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
    notes: list[Note]
    odd: OddMessages
    """What the first pass found odd about single messages."""
    time_notes: list[Note]
    """Those on single streams' times, which are said last."""
    faults: tuple[str, ...]
    """What is wrong with the recording's files; empty for sound ones."""
    left_out: tuple[str, ...] = ()
    """Streams of which not one message can be decoded."""


def plan_episode(
    recording: Recording,
    robot: RobotConfig,
    config: IngestConfig,
    fixed: Contents | None,
    streams_to: Path | None = None,
    on_reached: Callable[[int], None] | None = None,
) -> EpisodePlan:
    """Read the recording once and lay its episode out on the grid.

    Args:
        fixed: Contents of the data set that the episode joins; None for the first one, whose contents it fixes.
        streams_to: Where to write the small streams at their own rates; None writes nothing.
        on_reached: Called with the record time of each message read.

    Raises:
        DatasetsError: If the recording has no stream that can span a grid, less than two ticks of it, or is silent for
            more than an hour.
    """
    topics = usable_topics(recording, robot)
    joint_names = tuple(robot.joint_names) if fixed is None else fixed.joint_names
    found = first_pass(recording, topics, joint_names, robot.joy, on_reached, robot.source_frames())
    add_from_transforms(found, recording, robot)
    topics = found.topics
    if not (grid_streams(found.streams) or lone_grid_streams(found.streams)):
        refuse_unreadable(found, (*grid_streams(found.unreadable), *lone_grid_streams(found.unreadable)))
    clocks = Clocks.of(found, config.sync)
    grid = lay_grid(recording, topics, clocks, config.fps)
    contents = fixed or contents_to_be(contents_of(found), robot)
    calibration, changed = _calibration(robot, found)
    read = small_streams(found, grid.times, calibration, robot)
    compared = measure_offsets(recording, topics.streams, clocks, grid.times, read.streams)
    if compared.clocks.offsets != clocks.offsets:
        clocks = compared.clocks
        grid = lay_grid(recording, topics, clocks, config.fps)
        read = small_streams(found, grid.times, calibration, robot)
    small, flag_notes = with_flag_sense(read.streams, inverted=robot.intervention.inverted)
    discharge = discharge_sign(robot.battery_current_sign, small.get("battery"))
    measured = small_columns(grid.ticks_ns, small, contents, config.sync, discharge.sign)
    views = picture_views(robot, found.streams)
    large = large_streams(found, grid, contents, config.sync, views)
    columns = measured.values | served_columns(large, contents, grid.ticks_ns)
    if streams_to is not None:
        write_streams(streams_to, small)
    notes = [*stream_faults(recording, found), *measured.notes, *discharge.notes, *read.odometry_notes]
    notes += [*geometry_notes(found, calibration, changed), *gravity_notes(small.get("imu")), *unreadable_notes(found)]
    notes += flag_notes
    notes += held_notes(large, grid, config.sync)
    notes += [*overrule_notes(robot, calibration), *recording.notes(), *level_notes(found.streams, views)]
    notes += deskew_notes(small, wanted=config.deskew and "lidar" in large)
    return EpisodePlan(
        topics=topics,
        found=contents_of(found),
        contents=contents,
        ticks_ns=grid.ticks_ns,
        columns=columns,
        large=large,
        motion=motion_of(small.get("odometry"), config.sync.odometry.tolerance_s) if config.deskew else None,
        calibration=calibration,
        recording_start_ns=clocks.on_clock_of(grid.stream, recording.start_ns),
        sync_report=sync_report(
            found, clocks, grid, columns, config.sync, compared.measured, {"odometry": read.odometry_notes}
        ),
        dropped=dropped_messages(found, grid, large, contents),
        notes=notes,
        odd=odd_of_first_pass(found, recording),
        time_notes=time_notes(clocks, grid),
        faults=recording.faults,
        left_out=tuple(found.unreadable),
    )


def _calibration(robot: RobotConfig, found: FirstPass) -> tuple[Calibration, tuple[str, ...]]:
    """The episode's geometry, and the static transforms that were published with different values."""
    transforms, changed = latest_transforms(found.transforms)
    frames = {name: stream.frame_id for name, stream in found.streams.items()}
    infos = {sensor_of(stream): info for stream, info in found.camera_infos.items()}
    first = infos.pop("", None)
    return calibrate(robot, RecordedGeometry(frames, transforms, first, infos), _images(found)), changed


def _images(found: FirstPass) -> dict[str, CameraImages]:
    """The pictures of each camera."""
    images = {}
    for stream in of_kind("camera", found.topics.streams):
        seen = found.streams.get(stream)
        native_size, row_size = None if seen is None else seen.native_size, (IMAGE_WIDTH_PX, IMAGE_HEIGHT_PX)
        images[stream] = CameraImages(found.topics.streams[stream], native_size, row_size)
    return images
