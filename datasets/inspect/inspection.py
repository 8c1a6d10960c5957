"""What a recording holds: topics, rates, gaps, clocks, and the topic map that ingest would use."""

from array import array
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.plain import plain_fields
from navtool.datasets.recording import Recording, Topic, open_recording
from navtool.datasets.robot.config import InterventionFlag, RobotConfig
from navtool.datasets.robot.front_camera import recorded_topic_map
from navtool.datasets.robot.sensor_config import FurtherCamera, FurtherLidar
from navtool.datasets.robot.topic_map import TopicMap
from navtool.datasets.streams.first_pass import look_at, without_pictures
from navtool.datasets.streams.flag_sense import says_good
from navtool.datasets.streams.found_notes import UNDECODABLE, level_notes, picture_views
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.table import is_large, of_kind, sensor_of


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicReport:
    """One topic of a recording.

    Attributes:
        name: The topic.
        type: Its message type as ``pkg/msg/Name``.
        count: Number of messages.
        rate_hz: Mean rate from the first to the last stamp; None with fewer than two stamps.
        gap_max_s: Longest time between two neighbouring stamps in order of time; None likewise.
        time: ``header`` where rate and gaps are of the header stamps, ``record`` where of the times of record.
        clock_offset_s: Median of header stamp minus time of record; None without header stamps.
        backwards: Stamps older than that of the message recorded before.
        zero_stamps: Headers whose stamp was left empty.
        unreadable: Messages shorter than their header.
    """

    name: str
    type: str
    count: int
    rate_hz: float | None = None
    gap_max_s: float | None = None
    time: str = "record"
    clock_offset_s: float | None = None
    backwards: int = 0
    zero_stamps: int = 0
    unreadable: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """A recording as its user wants to know it before ingesting; times of start and end are times of record."""

    path: str
    format: str
    start_ns: int
    end_ns: int
    messages: int
    topics: tuple[TopicReport, ...]
    topic_map: TopicMap
    faults: tuple[str, ...]
    """What is wrong with its files and was skipped or done without; empty for a sound one."""
    notes: tuple[Note, ...] = ()
    """What is odd about its files, definitions, and the first pictures and clouds."""

    def to_json(self) -> dict[str, object]:
        """Everything as plain JSON values; every stream is a key of ``topic_map``, null where it has no topic."""
        return plain_fields(self) | {"topic_map": self.topic_map.to_json()}


def robot_from(base: RobotConfig, inspection: Inspection) -> RobotConfig:
    """The robot with the topics that the inspection found, to save and to edit, further cameras and LiDARs too.

    A stream that the recording lacks keeps the base's candidates: other recordings of the robot may have it.
    """
    read = inspection.topic_map.streams
    first = {stream: [topic] for stream, topic in read.items() if not sensor_of(stream)}
    found = dict(inspection.topic_map.further) | dict(read)
    cameras, lidars = dict(base.cameras), dict(base.lidars)
    for stream in of_kind("camera", found):
        if name := sensor_of(stream):
            known = cameras.get(name, FurtherCamera(topics=[found[stream]]))
            cameras[name] = replace(known, topics=[found[stream]])
    for stream in of_kind("lidar", found):
        if name := sensor_of(stream):
            lidars[name] = replace(lidars.get(name, FurtherLidar(topics=[found[stream]])), topics=[found[stream]])
    flag = base.intervention
    if flag.inverted is None and says_good(read.get("intervention", "")):
        flag = InterventionFlag(inverted=True)
    topics = replace(base.topics, **first)
    return replace(base, topics=topics, cameras=cameras, lidars=lidars, intervention=flag)


@dataclass(slots=True)
class _Times:
    record_ns: array[int] = field(default_factory=lambda: array("q"))
    header_ns: array[int] = field(default_factory=lambda: array("q"))
    unreadable: int = 0


def inspect_recording(
    path: Path,
    robot: RobotConfig | None = None,
    *,
    ros_distro: str = "humble",
    on_read: Callable[[int], None] | None = None,
) -> Inspection:
    """Read a recording once and describe it.

    Of messages the header's stamp is read; the first ones of each camera and LiDAR are decoded, as ingest does.

    Memory holds 16 bytes a message beside what reading takes, 32 of cameras and LiDARs.

    Args:
        path: The recording.
        robot: Its topics are looked for; None proposes a map from types and names.
        ros_distro: Whose definitions to use where a ROS 2 recording embeds none.
        on_read: Called with the size of each message in bytes.

    Raises:
        DatasetsError: If it is not a recording, is damaged, or has a candidate topic of another type.
    """
    with open_recording(path, ros_distro=ros_distro) as recording:
        topic_map = recorded_topic_map(robot or RobotConfig(), recording)
        large = {topic: RecordedStream(topic) for name, topic in topic_map.streams.items() if is_large(name)}
        times = _times(recording, large, on_read)
        return Inspection(
            path=str(path),
            format=recording.format.value,
            start_ns=recording.start_ns,
            end_ns=recording.end_ns,
            messages=recording.message_count,
            topics=tuple(_report(topic, times.get((topic.name, topic.type), _Times())) for topic in recording.topics),
            topic_map=topic_map,
            faults=recording.faults,
            notes=(*recording.notes(), *_large_notes(robot or RobotConfig(), topic_map, large)),
        )


def _large_notes(robot: RobotConfig, topics: TopicMap, large: Mapping[str, RecordedStream]) -> list[Note]:
    """What the first pictures and clouds say, by stream."""
    streams = {name: large[topic] for name, topic in topics.streams.items() if topic in large and is_large(name)}
    notes = []
    for name, stream in streams.items():
        if stream.record_ns and stream.native_size is None:
            fault = without_pictures(stream).first_fault
            notes.append(Note(UNDECODABLE, f"{name}: its messages cannot be decoded: {fault}"))
        notes += [note.about(name) for note in stream.notes]
    return [*notes, *level_notes(streams, picture_views(robot, streams))]


def _times(
    recording: Recording, large: Mapping[str, RecordedStream], on_read: Callable[[int], None] | None
) -> dict[tuple[str, str], _Times]:
    times: dict[tuple[str, str], _Times] = {}
    names = {topic.name for topic in recording.topics if topic.count > 0}
    for raw in recording.messages(names):
        of_topic = times.setdefault((raw.topic, raw.type), _Times())
        of_topic.record_ns.append(raw.record_ns)
        try:
            stamp_ns = recording.header_stamp_ns(raw)
        except DatasetsError:
            of_topic.unreadable += 1
            stamp_ns = None
        if raw.topic in large:
            look_at(large[raw.topic], recording, raw)
        of_topic.header_ns.append(-1 if stamp_ns is None else stamp_ns)
        if on_read is not None:
            on_read(len(raw.data))
    return times


def _report(topic: Topic, times: _Times) -> TopicReport:
    record_ns, header_ns = np.array(times.record_ns, dtype=np.int64), np.array(times.header_ns, dtype=np.int64)
    stamped = header_ns > 0
    by_header = 2 * int(stamped.sum()) > stamped.size
    stamps = header_ns[stamped] if by_header else record_ns
    steps = np.diff(np.sort(stamps))
    span_s = float(steps.sum()) * 1e-9
    return TopicReport(
        name=topic.name,
        type=topic.type,
        count=topic.count,
        rate_hz=steps.size / span_s if span_s > 0 else None,
        gap_max_s=float(steps.max()) * 1e-9 if steps.size else None,
        time="header" if by_header else "record",
        clock_offset_s=float(np.median(header_ns[stamped] - record_ns[stamped])) * 1e-9 if stamped.any() else None,
        backwards=int((np.diff(stamps) < 0).sum()),
        zero_stamps=int((header_ns == 0).sum()),
        unreadable=times.unreadable,
    )
