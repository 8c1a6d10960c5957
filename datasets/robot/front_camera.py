"""Which of several cameras looks ahead: by where it is mounted, if the recording says so, before its name."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.decode.messages import Transform, TransformsSample
from navtool.datasets.recording import Recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.recorded_geometry import TransformTree, latest_transforms
from navtool.datasets.robot.topic_map import TopicMap, resolve_topic_map
from navtool.datasets.streams.table import STREAMS, of_kind
from navtool.pipeline.arrays import Array

_AHEAD_RAD = np.radians(30.0)
_ASIDE_RAD = np.radians(45.0)
_NAMED = 4
"""Score of a name that says that its camera is the front one."""


def recorded_topic_map(robot: RobotConfig, recording: Recording) -> TopicMap:
    """The topic map of a recording; of several cameras that are only proposed the one that looks ahead is the first.

    Where static transforms say where the cameras look, they count before the names; the first message of each camera
    and the transforms are read for it. Where they say nothing the name does, which a note says.

    Raises:
        DatasetsError: As of `resolve_topic_map`.
    """
    topics = resolve_topic_map(robot, recording.topics)
    cameras = [topics.further[stream] for stream in of_kind("camera", topics.further)]
    first = topics.topic_of("camera")
    if robot.topics.camera or first is None or not cameras:
        return topics
    aside = _aside(recording, robot, topics, (first, *cameras))
    if aside.get(first, np.pi) <= _ASIDE_RAD:
        return topics
    ahead = min(
        (topic for topic in cameras if aside.get(topic, np.pi) <= _AHEAD_RAD), key=aside.__getitem__, default=""
    )
    by_name = (STREAMS["camera"].hints.score(first) or 0) >= _NAMED
    if ahead and (first in aside or not by_name):
        named = replace(robot, topics=replace(robot.topics, camera=[ahead]))
        text = f"camera: {ahead} is taken for the front camera: by tf it looks ahead, {first} does not or is not in it"
        found = resolve_topic_map(named, recording.topics)
        return replace(found, notes=(*found.notes, Note("topics.front-by-tf", text)))
    if first in aside:
        text = f"camera: by tf {first} looks {np.degrees(aside[first]):.0f} deg aside, and no other camera looks ahead"
    else:
        text = f"camera: {first} is taken for the front camera by its name alone: tf does not say where it looks"
    return replace(topics, notes=(*topics.notes, Note("topics.front-by-name", text)))


def _aside(recording: Recording, robot: RobotConfig, topics: TopicMap, cameras: tuple[str, ...]) -> Mapping[str, float]:
    """Angle between straight ahead and where each camera looks, of those whose pose the static transforms tell."""
    static = tuple(topic for topic in topics.transforms if topic.endswith("tf_static"))
    transforms: list[Transform] = []
    for raw in recording.messages(static):
        try:
            sample = recording.decode(raw)
        except DatasetsError:
            continue
        if isinstance(sample, TransformsSample):
            transforms += sample.transforms
    if not transforms:
        return {}
    tree = TransformTree(latest_transforms(transforms)[0])
    found = {}
    for topic in cameras:
        frame = next((recording.header_frame(raw) for raw in recording.messages((topic,))), "")
        pose = tree.pose(robot.base_frame, frame) if frame else None
        if pose is not None:
            found[topic] = float(np.arccos(np.clip(_axis(pose)[0], -1.0, 1.0)))
    return found


def _axis(pose: Float64[Array, "4 4"]) -> Float64[Array, " 3"]:
    """Where a camera looks: along z of an optical frame, whose y points down; along x of a frame whose z points up."""
    level: Array = pose[:3, 0] if pose[2, 2] > np.abs(pose[2, 1]) else pose[:3, 2]
    return level
