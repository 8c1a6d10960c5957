"""Sweeps straight from a recording, of whatever container and driver."""

from collections.abc import Callable, Iterator
from dataclasses import fields, replace

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.recording.changed import changed_meanwhile
from navtool.datasets.recording.identity import source_name
from navtool.datasets.robot.calibration import calibrate
from navtool.datasets.robot.config import NO_TOPIC, RobotConfig, TopicCandidates
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, latest_transforms
from navtool.datasets.robot.topic_map import TopicMap, resolve_topic_map
from navtool.datasets.streams.align import in_base_axes
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import FirstPass, first_pass
from navtool.datasets.streams.odometry_heading import turned_odometry
from navtool.datasets.streams.timed_stream import TimedStream, motion_of
from navtool.methods.along.sweeps import Pending, SweepConfig, SweepSource

_NEEDED = ("lidar", "odometry")


class RecordedSweeps(SweepSource):
    """The sweeps of an open recording. Making it reads the recording once, for stamps, odometry and transforms.

    Args:
        recording: Open as long as the sweeps are read.
        robot: Its topics, frames and mounting, as for ingest.
        config: What becomes of a cloud.

    Raises:
        DatasetsError: The recording cannot be read, or has no clouds.
    """

    def __init__(self, recording: Recording, robot: RobotConfig, config: SweepConfig) -> None:
        topics = _needed_topics(recording, robot)
        found = first_pass(recording, topics, ())
        if "lidar" not in found.streams:
            raise _no_clouds(recording, topics)
        times = Clocks.of(found, SyncConfig()).times("lidar")
        transforms, _ = latest_transforms(found.transforms)
        frames = {name: stream.frame_id for name, stream in found.streams.items()}
        calibration = calibrate(robot, RecordedGeometry(frames, transforms), None)
        odometry = None
        if "odometry" in found.streams:
            recorded = {"odometry": TimedStream.of(found.streams["odometry"], times["odometry"])}
            odometry = turned_odometry(in_base_axes(recorded, calibration)["odometry"], robot.odometry_yaw_rad)
        motion = motion_of(odometry, config.odometry_gap_s)
        super().__init__(source_name(recording.path), found.streams["lidar"].topic, calibration, motion, config)
        self.notes = [*(f"recovered: {fault}" for fault in recording.faults), *topics.notes, *self.notes]
        self.notes += _stream_notes(found)
        self._recording = recording
        if "odometry" in found.streams:
            self.odometry_frame = _frame_of(recording, found.streams["odometry"].topic) or self.odometry_frame
        self._record_ns = found.streams["lidar"].record_ns
        # A cloud without a usable stamp keeps the time of its record, as in a data set.
        self._stamps_ns = np.array(self._record_ns, dtype=np.int64)
        self._stamps_ns[times["lidar"].order] = times["lidar"].stamps_ns
        self.clouds = len(self._record_ns)
        self.duration_s = float(np.ptp(self._stamps_ns)) * 1e-9

    def _pending(self) -> Iterator[Pending]:
        expected = zip(self._record_ns, self._stamps_ns.tolist(), strict=True)
        for raw in self._recording.messages([self.topic]):
            record_ns, stamp_ns = next(expected, (None, 0))
            if record_ns != raw.record_ns:
                raise changed_meanwhile(self._recording.path)
            yield Pending(stamp_ns, _reader(self._recording, raw))
        if next(expected, None) is not None:
            raise changed_meanwhile(self._recording.path)


def _frame_of(recording: Recording, topic: str) -> str | None:
    """The frame of the poses on a topic, by the first message that can be read; None where none tells it."""
    for raw in recording.messages([topic]):
        try:
            sample = recording.decode(raw)
        except DatasetsError:
            continue
        return getattr(sample, "frame_id", None)
    return None


def _reader(recording: Recording, raw: RawMessage) -> Callable[[], PointCloud]:
    def read() -> PointCloud:
        sample = recording.decode(raw)
        if not isinstance(sample, PointCloud):
            raise TypeError(f"{type(sample).__name__} is no cloud")
        return sample

    return read


def _needed_topics(recording: Recording, robot: RobotConfig) -> TopicMap:
    """The topics of clouds, odometry and transforms: what else a recording holds is neither read nor judged."""
    others = {x.name: [NO_TOPIC] for x in fields(TopicCandidates) if x.name not in _NEEDED}
    topics = resolve_topic_map(replace(robot.topics, **others), recording.topics)
    if topics.lidar is None:
        raise _no_clouds(recording, topics)
    return topics


def _no_clouds(recording: Recording, topics: TopicMap) -> DatasetsError:
    what = "the recording has no point clouds"
    if recording.message_count == 0:
        what = "the recording has no messages"
    elif topics.notes:
        what += f" ({'; '.join(topics.notes)})"
    listed = ", ".join(f"{topic.name} ({topic.type})" for topic in recording.topics if topic.count)
    cure = "name their topic with robot.topics.lidar=[/topic]"
    return DatasetsError(f"{what}; it has {listed or 'nothing'}", where=recording.path, cure=cure)


def _stream_notes(found: FirstPass) -> list[str]:
    """What cannot be used of odometry and transforms."""
    notes = [f"{topic}: cannot be used: {fault}" for topic, fault in found.faults.items()]
    notes += [
        f"{name}: not one of {stream.undecodable} messages on {stream.topic} can be decoded: {stream.first_fault}"
        for name, stream in found.unreadable.items()
    ]
    odometry = found.streams.get("odometry")
    if odometry is not None and odometry.undecodable:
        notes.append(f"odometry: {odometry.undecodable} messages cannot be decoded: {odometry.first_fault}")
    return notes
