"""Several sensors that publish on one topic: one of them is read, the others are left out by name, and never mixed."""

from collections.abc import Mapping, Sequence

import numpy as np
from jaxtyping import Bool

from navtool.base.note import Note
from navtool.datasets.robot.recorded_geometry import TransformTree
from navtool.datasets.streams.recorded_stream import RecordedStream, Source
from navtool.datasets.streams.table import POSED, is_large, row_of, sensor_of
from navtool.pipeline.arrays import Array

SEVERAL = "topic.several-sources"
"""Code of the notes that say which sources a topic has, and which is read."""

_MOST = 8
"""More are no sensors: the frame's name says something else of each message."""
_SAME = 1e-3
"""Metres, or parts of a rotation, within which two frames are one."""


def tell_apart(streams: Mapping[str, RecordedStream], tree: TransformTree, frames: Mapping[str, str]) -> list[Note]:
    """Leave out of each sensor's stream what comes from another sensor than most of its messages.

    Sensors differ in their frame, or in the node that published them. One that follows the other, as a driver does that
    was started again, is the same where its frame is at the same place. Positions of images and clouds in the order of
    record stay; rows of small streams are taken out.

    Args:
        frames: The frame that is wanted of a stream, where the robot file says so.

    Returns:
        What a user should know.
    """
    return [
        note
        for name, stream in streams.items()
        if row_of(name).pose or row_of(name).name == "battery"
        if (note := _told_apart(name, stream, tree, frames.get(name, ""), _taken(name, streams, frames))) is not None
    ]


def _taken(name: str, streams: Mapping[str, RecordedStream], frames: Mapping[str, str]) -> set[str]:
    """The frames on a stream's topic that other streams are to have."""
    return {
        frames[other].lstrip("/")
        for other, stream in streams.items()
        if other != name and other in frames and stream.topic == streams[name].topic
    }


def _told_apart(name: str, stream: RecordedStream, tree: TransformTree, wanted: str, taken: set[str]) -> Note | None:
    _join_single_messages(stream)
    if len(stream.sources) < 2 and not (wanted and stream.sources):
        return None
    topic = stream.topic
    listed = _listed(stream)
    if len(stream.sources) > _MOST:
        text = f"{name}: the messages on {topic} name {len(stream.sources)} frames; they are taken for one sensor's"
        return Note(SEVERAL, text)
    chosen = _chosen(stream, wanted, taken)
    if chosen is None:
        stream.leave_out(np.ones(len(stream.source), dtype=np.bool_))
        return Note(SEVERAL, f"{name}: none of the messages on {topic} is of {wanted}: {listed}")
    kept: Array = np.array(stream.source) == list(stream.sources).index(chosen)
    for number, source in enumerate(stream.sources):
        others: Array = np.array(stream.source) == number
        if source != chosen and _follows(kept, others) and _at_same_place(tree, source, chosen):
            kept |= others
    stream.frame_id = chosen.frame
    stream.native_size = stream.native_sizes.get(list(stream.sources).index(chosen), stream.native_size)
    if kept.all():
        return None
    stream.leave_out(~kept)
    if taken or sensor_of(name):
        return None
    text = f"{name}: {len(stream.sources)} sources publish on {topic}: {listed}; {_named(chosen, stream)} is read, the "
    text += f"others are left out ({int((~kept).sum())} messages){_cure(name, stream, chosen)}"
    return Note(SEVERAL, text)


def _join_single_messages(stream: RecordedStream) -> None:
    """Count sources of one message to the source of most: damage rather than a sensor."""
    if len(stream.sources) < 2:
        return
    counts = np.bincount(stream.source, minlength=len(stream.sources))
    most = int(np.argmax(counts))
    of_old: Array = np.where(counts > 1, np.cumsum(counts > 1) - 1, -1)
    of_old[counts <= 1] = of_old[most]
    if of_old[most] < 0:
        return
    names = [name for name, count in zip(stream.sources, counts.tolist(), strict=True) if count > 1]
    stream.native_sizes = {int(of_old[old]): size for old, size in stream.native_sizes.items() if counts[old] > 1}
    stream.source = of_old[np.array(stream.source)].tolist()
    stream.sources = {name: number for number, name in enumerate(names)}


def _chosen(stream: RecordedStream, wanted: str, taken: set[str]) -> Source | None:
    """The source of the wanted frame, or that of most messages; the first one at a tie."""
    frames = {source: source.frame.lstrip("/") for source in stream.sources}
    fitting = [x for x, frame in frames.items() if (frame == wanted.lstrip("/") if wanted else frame not in taken)]
    counts = np.bincount(stream.source, minlength=len(stream.sources))
    numbers = {source: number for number, source in enumerate(stream.sources)}
    return max(fitting, key=lambda source: int(counts[numbers[source]]), default=None)


def _follows(kept: Bool[Array, " n"], others: Bool[Array, " n"]) -> bool:
    """Whether all of one lies before or behind all of the other."""
    a, b = np.flatnonzero(kept), np.flatnonzero(others)
    return bool(a[-1] < b[0] or b[-1] < a[0])


def _at_same_place(tree: TransformTree, first: Source, second: Source) -> bool:
    if (first.frame, first.parent) == (second.frame, second.parent):
        return True
    if first.parent != second.parent:
        return False
    pose = tree.pose(first.frame, second.frame)
    return pose is not None and bool(np.abs(pose - np.eye(4)).max() < _SAME)


def _listed(stream: RecordedStream) -> str:
    counts = np.bincount(stream.source, minlength=len(stream.sources))
    return ", ".join(
        f"{_named(source, stream)} ({count} messages)"
        for source, count in zip(stream.sources, counts.tolist(), strict=True)
    )


def _named(source: Source, stream: RecordedStream) -> str:
    """The source by what tells it from the others."""
    parts = {
        "frame": _told(source.frame, [other.frame for other in stream.sources]),
        "poses in": _told(source.parent, [other.parent for other in stream.sources]),
        "node": _told(source.publisher, [other.publisher for other in stream.sources]),
    }
    return " ".join(f"{what} {name}" for what, name in parts.items() if name) or "one"


def _told(name: str, names: Sequence[str]) -> str:
    return (name or "(none)") if len(set(names)) > 1 else ""


def _cure(name: str, stream: RecordedStream, chosen: Source) -> str:
    others = sorted({source.frame for source in stream.sources} - {chosen.frame, ""})
    if not others or name not in POSED:
        return ""
    group = "cameras" if row_of(name).pose == "base_camera" else "lidars"
    both = f", {group}: {{NAME: {{topics: [{stream.topic}], frame: {others[0]}}}}} in a robot file both"
    return f"; robot.frames.{name}={others[0]} reads another one{both if is_large(name) else ''}"
