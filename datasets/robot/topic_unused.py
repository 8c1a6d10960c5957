"""Why a topic of a recording feeds no stream of the data set."""

import re
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from navtool.datasets.decode.table import MESSAGES
from navtool.datasets.recording import Topic
from navtool.datasets.robot.camera_topics import camera_name
from navtool.datasets.streams.table import STREAMS, Kind, of_kind


@dataclass(frozen=True, slots=True)
class UnusedTopic:
    """A topic that is in the recording and not in the data set."""

    name: str
    type: str
    count: int
    reason: str


_BY_TYPE = (
    (r"^sensor_msgs/msg/MultiEchoLaserScan$", "a planar scan of several echoes; record one of them as a LaserScan"),
    (
        r"(PandarScan|PacketMsg|Packets?)$",
        "raw packets of a sensor, which are not decoded; record its driver's PointCloud2",
    ),
    (r"^theora_image_transport/msg/Packet$", "a video stream of Theora, which is not decoded; record images"),
    (r"^sensor_msgs/msg/(NavSatFix|NavSatStatus)$", "satellite positions have no column in the data set"),
)
"""Types that are not read, or for no stream: regular expression on the type, reason; the first match wins."""

_STANDARD = re.compile(
    r"^((std|geometry|sensor|nav|diagnostic|visualization|trajectory|stereo|shape|rosgraph)_msgs|rcl_interfaces)/"
)


def unused_topics(
    topics: Sequence[Topic], chosen: Mapping[str, str | None], transforms: Collection[str]
) -> tuple[UnusedTopic, ...]:
    """Every topic that is neither chosen for a stream nor a transform, by name, with the reason."""
    used = {name for name in chosen.values() if name is not None} | set(transforms)
    left = [topic for topic in topics if topic.name not in used or topic.count == 0]
    rest = sorted(left, key=lambda topic: (topic.name, topic.type))
    several = {name for name, kinds in Counter(topic.name for topic in rest if topic.count).items() if kinds > 1}
    return tuple(
        UnusedTopic(
            name=topic.name,
            type=topic.type,
            count=topic.count,
            reason="carries messages of several types" if topic.name in several else _reason(topic, chosen),
        )
        for topic in rest
    )


def _reason(topic: Topic, chosen: Mapping[str, str | None]) -> str:
    if topic.count == 0:
        return "no messages"
    for pattern, reason in _BY_TYPE:
        if re.search(pattern, topic.type):
            return reason
    message = MESSAGES.get(topic.type)
    if message is not None:
        if message.proposed:
            return _stream_reason(message.proposed[0], topic, chosen)
        if message.named:
            return message.unused or f"read as {' or '.join(message.named)} only where the robot file names it"
    if _STANDARD.match(topic.type):
        return "no stream of the data set takes this type"
    return f"no decoder for {topic.type}"


def _image_reason(name: str, chosen: Mapping[str, str | None]) -> str:
    if STREAMS["camera"].hints.score(name) is None:
        return "a depth or derived image; the data set takes colour images"
    read = [topic for stream in of_kind("camera", chosen) if (topic := chosen[stream]) is not None]
    if not read:
        return "a camera, and no camera is wanted"
    for image in read:
        if camera_name(name) == camera_name(image):
            return f"the same images as {image} in another encoding"
    return f"another camera; {read[0]} is used"


def _stream_reason(stream: str, topic: Topic, chosen: Mapping[str, str | None]) -> str:
    if stream == "camera":
        return _image_reason(topic.name, chosen)
    row, used = STREAMS[stream], chosen[stream]
    if used is not None:
        what = "a planar scan" if MESSAGES[topic.type].planar else row.another
        return f"{what}; {used} is used"
    if row.kind is Kind.geometry:
        return row.another
    if row.hints.score(topic.name) is None:
        return f"its name does not say that it is the {stream}; name it in the robot file if it is"
    return f"not among the robot's candidates for {stream}"
