"""First pass over a recording: every time stamp, and the small streams in full."""

import logging
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.levels import LevelSurvey
from navtool.datasets.decode.messages import (
    CameraInfoSample,
    Decoded,
    ImageFrame,
    PointCloud,
    Transform,
    TransformsSample,
    VideoPacket,
)
from navtool.datasets.decode.table import TRANSFORMS
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.robot.config import JoyCommand
from navtool.datasets.robot.recorded_geometry import TransformTree, latest_transforms
from navtool.datasets.robot.topic_map import TopicMap
from navtool.datasets.streams.clock import NO_STAMP
from navtool.datasets.streams.fast_rows import FastRows
from navtool.datasets.streams.joined_joints import join_joints
from navtool.datasets.streams.recorded_stream import RecordedStream, Source
from navtool.datasets.streams.rows import rows_of
from navtool.datasets.streams.sources import tell_apart
from navtool.datasets.streams.table import Kind, is_large, row_of, sensor_of
from navtool.datasets.streams.video_survey import VideoSurvey

logger = logging.getLogger(__name__)

_SOURCES = 8
"""Sensors on one topic of which the first message is decoded."""
_TRIES = 5
"""Messages of a large stream that may be broken before the stream counts as unreadable."""


@dataclass(slots=True)
class FirstPass:
    """What the first pass found."""

    topics: TopicMap
    streams: dict[str, RecordedStream]
    camera_infos: dict[str, CameraInfoSample] = field(default_factory=dict)
    """The first usable calibration of each camera, by its stream: ``camera_info``, ``camera_info.rear``."""
    transforms: list[Transform] = field(default_factory=list)
    faults: dict[str, str] = field(default_factory=dict)
    """Calibrations and transforms that cannot be used: the first fault by topic."""
    unreadable: dict[str, RecordedStream] = field(default_factory=dict)
    """Streams of which not one message can be decoded."""
    notes: list[Note] = field(default_factory=list)
    """What was done about topics that several publish on."""


def first_pass(
    recording: Recording,
    topics: TopicMap,
    joint_names: tuple[str, ...],
    joy: JoyCommand | None = None,
    on_reached: Callable[[int], None] | None = None,
    frames: Mapping[str, str] | None = None,
) -> FirstPass:
    """Read every mapped topic once, in the order of record.

    Images and clouds are not decoded beyond the first one (for its frame and size); every other stream is kept in
    full. A message that cannot be decoded is counted with its reason and does not end the pass.

    Args:
        joint_names: Order of the joints' columns; empty takes all in the order in which they come up.
        joy: What a joystick's axes mean, where one feeds the command.
        on_reached: Called with the record time of each message read.
        frames: Which sensor's frame is wanted of a stream's topic, where several publish on it.

    Raises:
        DatasetsError: If the recording cannot be read on.
    """
    by_topic: dict[str, list[str]] = {}
    for stream, topic in topics.streams.items():
        by_topic.setdefault(topic, []).append(stream)
    kinds = {topic.name: topic.type for topic in recording.topics}
    static = tuple(x for x in topics.transforms if x.endswith("tf_static") or kinds[x].startswith("foxglove"))
    found = FirstPass(
        topics,
        {
            name: RecordedStream(topic)
            for name, topic in topics.streams.items()
            if row_of(name).kind is not Kind.geometry
        },
    )
    fast = FastRows(recording)
    for raw in recording.messages((*by_topic, *static)):
        message = _Message(recording, raw)
        for stream in by_topic.get(raw.topic, (TRANSFORMS,)):
            if stream not in found.streams:
                _add_geometry(found, stream, recording, raw)
            elif is_large(stream):
                look_at(found.streams[stream], recording, raw)
            else:
                _add_row(found.streams[stream], stream, joy, message, fast)
        if on_reached is not None:
            on_reached(raw.record_ns)
    for name, recorded in found.streams.items():
        if recorded.video is not None:
            _add_video_picture(recorded, recorded.video.finish())
        if is_large(name) and recorded.record_ns and recorded.native_size is None:
            found.unreadable[name] = without_pictures(recorded)
        elif not recorded.record_ns and recorded.undecodable:
            found.unreadable[name] = recorded
    found.streams = {
        name: stream for name, stream in found.streams.items() if stream.record_ns and name not in found.unreadable
    }
    transforms, _ = latest_transforms(found.transforms)
    found.notes += tell_apart(found.streams, TransformTree(transforms), frames or {})
    found.streams = {name: stream for name, stream in found.streams.items() if stream.read}
    if "joints" in found.streams:
        found.notes += join_joints(found.streams["joints"], joint_names)
    return found


def look_at(stream: RecordedStream, recording: Recording, raw: RawMessage) -> None:
    """Keep the stamps of a message of a large stream, and what its first ones say of all: size, range, key frames."""
    try:
        stamp = recording.header_stamp_ns(raw)
    except DatasetsError as error:
        _count_fault(stream, error)
        stamp = 0  # keeps its place: the second pass counts messages in the order of record
        source = next(reversed(stream.sources), Source())
    else:
        source = Source(recording.header_frame(raw), publisher=raw.publisher)
    stream.count(NO_STAMP if stamp is None else stamp, raw.record_ns, source)
    number = stream.source[-1]
    surveyed = stream.survey is not None and stream.survey.wants(raw.record_ns)
    first = number < _SOURCES and number not in stream.native_sizes and stream.undecodable < _TRIES
    if not (surveyed or first or stream.video is not None):
        return
    try:
        sample = recording.decode(raw)
    except DatasetsError as error:
        _count_fault(stream, error)
        return
    if isinstance(sample, VideoPacket):
        stream.video = stream.video or VideoSurvey()
        _add_video_picture(stream, stream.video.add(sample, len(stream.record_ns) - 1))
    elif isinstance(sample, ImageFrame):
        _add_picture(stream, sample, raw.record_ns)
        stream.native_sizes[number] = (sample.rgb.shape[1], sample.rgb.shape[0])
    elif isinstance(sample, PointCloud):
        stream.native_sizes[number] = (len(sample.xyz), 1)
        if stream.native_size is None:
            stream.frame_id, stream.notes = sample.frame_id, list(sample.notes)
            stream.native_size = stream.native_sizes[number]


def _add_video_picture(stream: RecordedStream, picture: ImageFrame | None) -> None:
    """Frame and size of a video's first picture, once there is one."""
    if picture is not None and stream.native_size is None:
        stream.frame_id, stream.native_size = picture.frame_id, (picture.rgb.shape[1], picture.rgb.shape[0])


def _add_picture(stream: RecordedStream, picture: ImageFrame, record_ns: int) -> None:
    """The first picture's frame and size, and of those of 16 bits the range over the first seconds."""
    if stream.native_size is None:
        stream.frame_id, stream.notes = picture.frame_id, list(picture.notes)
        stream.native_size = (picture.rgb.shape[1], picture.rgb.shape[0])
    if picture.deep is not None:
        stream.survey = stream.survey or LevelSurvey(record_ns)
        stream.survey.add(picture.deep.samples, record_ns)


@dataclass(slots=True)
class _Message:
    """A message that is decoded once, however many streams it feeds."""

    recording: Recording
    raw: RawMessage
    _decoded: Decoded | DatasetsError | None = None

    def decode(self) -> Decoded:
        if self._decoded is None:
            try:
                self._decoded = self.recording.decode(self.raw)
            except DatasetsError as error:
                self._decoded = error
        if isinstance(self._decoded, DatasetsError):
            raise self._decoded
        return self._decoded


def _add_row(stream: RecordedStream, name: str, joy: JoyCommand | None, message: _Message, fast: FastRows) -> None:
    raw = message.raw
    rows = None if name == "command" and not raw.type.endswith("/TwistStamped") else fast.row(raw)
    if rows is None:
        try:
            rows = rows_of(message.decode(), name, joy)
        except DatasetsError as error:
            _count_fault(stream, error)
            return
    if not stream.columns:
        stream.columns, stream.frame_id = rows.columns, rows.frame_id
    joints = bool(rows.joint_names)
    source = Source(joints=rows.joint_names) if joints else Source(rows.frame_id, rows.parent, raw.publisher)
    stream.count(NO_STAMP if rows.stamp_ns is None else rows.stamp_ns, raw.record_ns, source)
    stream.rows.append(rows.values)


def _add_geometry(found: FirstPass, stream: str, recording: Recording, raw: RawMessage) -> None:
    """The first usable calibration, and every static transform; one that cannot be used is noted once a topic."""
    if stream in found.camera_infos:
        return
    try:
        sample = recording.decode(raw)
    except DatasetsError as error:
        found.faults.setdefault(raw.topic, error.what)
        return
    if isinstance(sample, CameraInfoSample):
        found.camera_infos[stream] = sample
    elif isinstance(sample, TransformsSample):
        if raw.type.startswith("foxglove"):
            # Static and moving frames share a topic: of each pair the first counts.
            known = {(x.parent, x.child) for x in found.transforms}
            found.transforms += [x for x in sample.transforms if (x.parent, x.child) not in known]
        else:
            found.transforms.extend(sample.transforms)


def _count_fault(stream: RecordedStream, error: DatasetsError) -> None:
    stream.undecodable += 1
    stream.first_fault = stream.first_fault or error.what
    logger.debug("%s: %s", stream.topic, error)


def refuse_unreadable(found: FirstPass, names: Iterable[str]) -> None:
    """Do nothing, but where one of the streams cannot be read.

    Raises:
        DatasetsError: Not one message of it can be decoded.
    """
    for name in names:
        if (stream := found.unreadable.get(name)) is not None:
            raise DatasetsError(
                f"not one of {stream.undecodable} messages can be decoded: {stream.first_fault}",
                where=stream.topic,
                cure=f"name another topic for '{name}', or leave the stream out{_without(name)}",
            )


def without_pictures(stream: RecordedStream) -> RecordedStream:
    """A stream of images or clouds of which none came of the first messages: all of them count as not decodable."""
    return replace(stream, undecodable=len(stream.record_ns), first_fault=_why_no_picture(stream))


def _why_no_picture(stream: RecordedStream) -> str:
    if stream.video is None:
        return stream.first_fault
    video = f"video stream of {' and '.join(stream.video.codecs)}"
    if not stream.video.keys:
        return f"a {video} without a key frame among its {stream.video.packets} packets: none of them can be decoded"
    return f"a {video} of which no picture can be decoded, from {len(stream.video.keys)} key frames on"


def _without(name: str) -> str:
    """How a stream is left out, where that is an override."""
    return "" if sensor_of(name) else f" with robot.topics.{name}=[none]"
