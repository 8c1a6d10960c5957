"""The streams of a recording, of whatever container and driver."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import fields, replace

import numpy as np
from jaxtyping import Int64

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.recording.changed import changed_meanwhile
from navtool.datasets.recording.identity import source_name
from navtool.datasets.robot.calibration import calibrate
from navtool.datasets.robot.config import RobotConfig, TopicCandidates
from navtool.datasets.robot.recorded_geometry import RecordedGeometry, latest_transforms
from navtool.datasets.robot.sensor_config import NO_TOPIC
from navtool.datasets.robot.topic_map import TopicMap, resolve_topic_map
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.config import SyncConfig
from navtool.datasets.streams.first_pass import FirstPass, first_pass, refuse_unreadable
from navtool.datasets.streams.found_notes import recovered_notes, refused_notes, unreadable_notes
from navtool.datasets.streams.from_transforms import add_from_transforms, may_hold_odometry
from navtool.datasets.streams.rows import ODOMETRY_COLUMNS
from navtool.datasets.streams.small_streams import SmallStreams, small_streams
from navtool.methods.along.odometry_table import OdometryTable
from navtool.methods.along.streams import Cloud, Streams
from navtool.pipeline.arrays import Array

_NOUNS = {"lidar": "point clouds", "odometry": "odometry"}


class RecordedStreams(Streams):
    """The streams of an open recording. Making it reads the recording once: stamps, odometry and transforms.

    Args:
        recording: Open as long as the streams are read.
        robot: Its topics, frames and mounting, as for ingest.
        sync: Which time counts, as for ingest.
        reads: The streams that are wanted; the first has to be there, and its clock is that of the others.
        odometry_gap_s: Poses further apart than this are not interpolated between.

    Raises:
        DatasetsError: The recording cannot be read, or lacks the first of the streams.
    """

    def __init__(
        self, recording: Recording, robot: RobotConfig, sync: SyncConfig, reads: Sequence[str], odometry_gap_s: float
    ) -> None:
        topics = _topics(recording, robot, reads)
        found = first_pass(recording, topics, (), frames=robot.source_frames())
        add_from_transforms(found, recording, robot, odometry="odometry" in reads)
        if reads[0] not in found.streams:
            refuse_unreadable(found, reads[:1])
            raise _missing(recording, topics, reads[0])
        times = Clocks.of(found, sync).times(reads[0])
        transforms, _ = latest_transforms(found.transforms)
        frames = {name: stream.frame_id for name, stream in found.streams.items()}
        calibration = calibrate(robot, RecordedGeometry(frames, transforms), {})
        small = small_streams(found, times, calibration, robot)
        odometry = _odometry(small)
        there = {name: stream.topic for name, stream in found.streams.items()}
        super().__init__(source_name(recording.path), there, calibration, odometry, odometry_gap_s)
        self.notes = [*recovered_notes(recording), *topics.notes, *self.notes]
        self.notes += [*found.notes, *_stream_notes(found), *small.odometry_notes]
        self._recording = recording
        if "odometry" in there:
            self.odometry_frame = _frame_of(recording, there["odometry"]) or self.odometry_frame
        self._kept = None if "lidar" not in there else found.streams["lidar"].kept
        self._record_ns = found.streams["lidar"].record_ns if "lidar" in there else []
        self._stamps_ns = np.array(self._record_ns, dtype=np.int64)
        if "lidar" in there:
            # A cloud without a usable stamp keeps the time of its record, as in a data set.
            self._stamps_ns[times["lidar"].order] = times["lidar"].stamps_ns

    @property
    def cloud_stamps_ns(self) -> Int64[Array, " clouds"]:
        """When each cloud was measured, in the order of record."""
        return self._stamps_ns if self._kept is None else self._stamps_ns[self._kept]

    def clouds(self) -> Iterator[Cloud]:
        """The clouds in the order of record."""
        if not self._record_ns:
            return
        kept = [True] * len(self._record_ns) if self._kept is None else self._kept.tolist()
        expected = zip(self._record_ns, self._stamps_ns.tolist(), kept, strict=True)
        for raw in self._recording.messages([self.topics["lidar"]]):
            record_ns, stamp_ns, wanted = next(expected, (None, 0, False))
            if record_ns != raw.record_ns:
                raise changed_meanwhile(self._recording.path)
            if wanted:
                yield Cloud(stamp_ns, _reader(self._recording, raw))
        if next(expected, None) is not None:
            raise changed_meanwhile(self._recording.path)


def _odometry(small: SmallStreams) -> OdometryTable | None:
    """The odometry of the base frame."""
    odometry = small.streams.get("odometry")
    if odometry is None or odometry.recorded.columns != ODOMETRY_COLUMNS:
        return None
    return OdometryTable(odometry.time.stamps_ns, odometry.values) if len(odometry.values) else None


def _frame_of(recording: Recording, topic: str) -> str | None:
    """The frame of the poses on a topic, by the first message that can be read; None where none has one."""
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


def _topics(recording: Recording, robot: RobotConfig, reads: Sequence[str]) -> TopicMap:
    """The topics of what is wanted, and of transforms: what else a recording holds is neither read nor judged."""
    others = {x.name: [NO_TOPIC] for x in fields(TopicCandidates) if x.name not in reads}
    # Further LiDARs stay named, so that their topics are not taken for the first one's.
    first = replace(robot, topics=replace(robot.topics, **others), cameras={})
    topics = resolve_topic_map(first, recording.topics)
    topics = replace(topics, streams={name: topic for name, topic in topics.streams.items() if name in reads})
    if reads[0] not in topics.streams and not (reads[0] == "odometry" and may_hold_odometry(topics, robot)):
        raise _missing(recording, topics, reads[0])
    return topics


def _missing(recording: Recording, topics: TopicMap, stream: str) -> DatasetsError:
    what = f"the recording has no {_NOUNS[stream]}"
    if recording.message_count == 0:
        what = "the recording has no messages"
    elif topics.notes:
        what += f" ({'; '.join(map(str, topics.notes))})"
    listed = ", ".join(f"{topic.name} ({topic.type})" for topic in recording.topics if topic.count)
    cure = f"name their topic with robot.topics.{stream}=[/topic]"
    return DatasetsError(f"{what}; it has {listed or 'nothing'}", where=recording.path, cure=cure)


def _stream_notes(found: FirstPass) -> list[Note]:
    """What cannot be used of the streams and transforms."""
    notes = [*refused_notes(found), *unreadable_notes(found)]
    odometry = found.streams.get("odometry")
    if odometry is not None and odometry.undecodable:
        what = f"odometry: {odometry.undecodable} messages cannot be decoded: {odometry.first_fault}"
        notes.append(Note("odometry.some-undecodable", what))
    return notes
