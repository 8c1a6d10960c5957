"""What a user should know of a recording's files and topics once it was read for the first time."""

from collections.abc import Mapping

from navtool.base.note import Note
from navtool.datasets.decode.levels import FULL, SURVEY_NS
from navtool.datasets.decode.picture_view import PictureView
from navtool.datasets.recording import Recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.table import FRONT, of_kind, sensor_of

UNDECODABLE = "stream.undecodable"
"""Code of the notes that say that no message of a stream can be decoded."""


def recovered_notes(recording: Recording) -> list[Note]:
    """Notes on what had to be skipped to read the recording."""
    return [Note("recording.recovered", f"recovered: {fault}") for fault in recording.faults]


def refused_notes(found: FirstPass) -> list[Note]:
    """Notes on topics that contradict themselves."""
    return [Note("topic.refused", f"{topic}: cannot be used: {fault}") for topic, fault in found.faults.items()]


def unreadable_notes(found: FirstPass) -> list[Note]:
    """Notes on streams of which not one message can be decoded."""
    return [
        Note(
            UNDECODABLE,
            f"{name}: not one of {stream.undecodable} messages on {stream.topic} can be decoded: {stream.first_fault}",
        )
        for name, stream in found.unreadable.items()
    ]


def picture_views(robot: RobotConfig, streams: Mapping[str, RecordedStream]) -> dict[str, PictureView]:
    """How each camera's pictures are shown."""
    surveys = {stream: streams[stream].survey for stream in of_kind("camera", streams)}
    return {name: robot.view_of(name, FULL if survey is None else survey.levels()) for name, survey in surveys.items()}


def level_notes(streams: Mapping[str, RecordedStream], views: Mapping[str, PictureView]) -> list[Note]:
    """A note on pictures of 16 bits of which not all are shown, by which range they are."""
    notes = []
    for stream, view in views.items():
        if streams[stream].survey is not None and not view.levels.is_full:
            low, high = view.levels.low, view.levels.high
            what = f"{stream}: samples of 16 bits from {low} to {high} are shown black to white, in the whole recording"
            cure = f"pictures: {{{sensor_of(stream) or FRONT}: {{range: [{low}, {high}]}}}} in the robot file sets them"
            notes.append(Note("image.range", f"{what}, by its first {SURVEY_NS * 1e-9:g} s; {cure}"))
    return notes
