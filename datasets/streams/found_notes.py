"""What a user should know of a recording's files and topics once it was read for the first time."""

from navtool.base.note import Note
from navtool.datasets.recording import Recording
from navtool.datasets.streams.first_pass import FirstPass


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
            "stream.undecodable",
            f"{name}: not one of {stream.undecodable} messages on {stream.topic} can be decoded: {stream.first_fault}",
        )
        for name, stream in found.unreadable.items()
    ]
