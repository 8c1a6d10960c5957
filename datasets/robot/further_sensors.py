"""Cameras and LiDARs of a recording beside the first ones: what they could be called in a robot file."""

import re
from collections.abc import Collection, Mapping, Sequence

from navtool.datasets.decode.table import MESSAGES, proposed_types
from navtool.datasets.recording import Topic
from navtool.datasets.robot.camera_topics import camera_name
from navtool.datasets.streams.table import FRONT, SENSOR_NAME, STREAMS, further, of_kind

_COMMON_WORDS = {
    "camera": {
        *("image", "images", "img", "camera", "cam"),
        *("raw", "compressed", "color", "colour", "rgb", "bgr", "hdr", "mono", "rect"),
    },
    "lidar": {"points", "points2", "point", "cloud", "pointcloud", "pointcloud2", "packets", "raw", "scan", "lidar"},
}
"""Words of a topic's name that do not tell one sensor from another; without its transport's name."""
_FALLBACK = {"camera": "camera", "lidar": "lidar"}


def propose_further(listed: Mapping[str, Topic], streams: Mapping[str, str]) -> dict[str, str]:
    """Topics by stream (``camera.rear``) of sensors that could be read beside those that are.

    One topic of each sensor: of a camera's encodings the raw one, of a cloud's forms the one whose name fits best. What
    was made from a sensor's messages is left out, and a planar scan unless the first LiDAR's clouds are planar too.
    """
    found: dict[str, str] = {}
    for kind in _COMMON_WORDS:
        if kind in streams:
            read = [streams[stream] for stream in of_kind(kind, streams)]
            names = {stream.partition(".")[2] or FRONT for stream in of_kind(kind, streams)}
            found |= _of_kind(kind, _sensors(kind, listed, streams[kind]), read, names)
    return found


def _sensors(kind: str, listed: Mapping[str, Topic], first: str) -> list[Topic]:
    """The topics that may be a sensor's, those that fit best in front."""
    hints, planar = STREAMS[kind].hints, MESSAGES[listed[first].type].planar
    types = proposed_types(kind)
    fitting = [
        topic
        for topic in listed.values()
        if topic.type in types
        and topic.count > 0
        and hints.score(topic.name) is not None
        and not hints.is_derived(topic.name)
        and (planar or not MESSAGES[topic.type].planar)
    ]
    return sorted(
        fitting,
        key=lambda topic: (types.index(topic.type), -(hints.score(topic.name) or 0), len(topic.name), topic.name),
    )


def _of_kind(kind: str, sensors: Sequence[Topic], read: Collection[str], names: set[str]) -> dict[str, str]:
    words = {topic.name: _words(kind, topic.name) for topic in sensors}
    words |= {name: _words(kind, name) for name in read}
    shared = set.intersection(*(set(of_topic) for of_topic in words.values()))
    seen = {words[name] for name in read}
    found: dict[str, str] = {}
    for topic in sorted(sensors, key=lambda topic: words[topic.name]):
        if words[topic.name] not in seen:
            seen.add(words[topic.name])
            telling = [word for word in words[topic.name] if word not in shared]
            name = _free("_".join(telling), kind, names)
            names.add(name)
            found[further(kind, name)] = topic.name
    return found


def _words(kind: str, topic: str) -> tuple[str, ...]:
    """The words of a topic's name that tell its sensor from others, each once."""
    words = dict.fromkeys(re.findall(r"[a-z0-9]+", camera_name(topic).lower()))
    return tuple(word for word in words if word not in _COMMON_WORDS[kind])


def _free(wanted: str, kind: str, names: Collection[str]) -> str:
    """The wanted name as a sensor may have it, with a number behind it where it is taken."""
    name = wanted if SENSOR_NAME.fullmatch(wanted) else f"{_FALLBACK[kind]}_{wanted}".rstrip("_")
    number, free = 2, name
    while free in names:
        number, free = number + 1, f"{name}_{number}"
    return free
