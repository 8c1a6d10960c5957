"""Which topic of a recording feeds which stream of the data set, and what is left over and why."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.plain import plain
from navtool.datasets.decode.table import MESSAGES, TRANSFORMS, proposed_types, readable_types
from navtool.datasets.recording import Topic
from navtool.datasets.robot.camera_topics import camera_name, camera_namespaces
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.further_sensors import propose_further
from navtool.datasets.robot.sensor_config import NO_TOPIC
from navtool.datasets.robot.topic_unused import UnusedTopic, unused_topics
from navtool.datasets.streams.table import STREAMS, further, is_large, row_of, sensor_of


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicMap:
    """The topic of every stream that a recording has, and every other topic with the reason."""

    streams: Mapping[str, str] = field(default_factory=dict)
    """Topics by stream, in the order of the stream table; of streams without a topic there is none."""
    transforms: tuple[str, ...] = ()
    """All tf topics with messages; they are always read."""
    not_used: tuple[UnusedTopic, ...] = ()
    """Every other topic, by name."""
    notes: tuple[Note, ...] = ()
    """What a user should look at: guesses, absent candidates."""
    further: Mapping[str, str] = field(default_factory=dict)
    """Topics of more cameras and LiDARs, by the streams that they would be; read only where a robot file names them."""

    def topic_of(self, stream: str) -> str | None:
        """The topic of a stream; None where it has none."""
        return self.streams.get(stream)

    def topics(self) -> tuple[str, ...]:
        """Every topic that is read, transforms included, without repetition."""
        return tuple(dict.fromkeys((*self.streams.values(), *self.transforms)))

    def to_json(self) -> dict[str, object]:
        """Every stream as a key, null where it has no topic; then the rest."""
        return {
            **dict.fromkeys(STREAMS),
            **self.streams,
            "further": dict(self.further),
            "transforms": list(self.transforms),
            "not_used": plain(self.not_used),
            "notes": plain(self.notes),
        }


def propose_topic_map(topics: Sequence[Topic]) -> TopicMap:
    """The map that types and names suggest; deterministic, and independent of the topics' order.

    A topic without messages is never chosen. Among topics of a fitting type the name decides (front before rear,
    colour before depth, a local odometry before one with GPS); equal names' scores go to the shorter name. A planar
    scan is chosen only where there is no other cloud.
    """
    return resolve_topic_map(RobotConfig(), topics)


def resolve_topic_map(robot: RobotConfig, topics: Sequence[Topic]) -> TopicMap:
    """The map that a robot's candidates give for this recording.

    Per stream the first candidate that has messages is taken. Where none has, the stream stays empty with a note:
    a named stream is never replaced by a guess. A stream without candidates is proposed, never from the topics of
    further cameras and LiDARs.

    Raises:
        DatasetsError: If a candidate is in the recording with another message type, or a topic is to feed two cameras
            or LiDARs; all such are named.
    """
    listed = _listed(topics)
    faults: list[str] = []
    notes: list[Note] = []
    chosen: dict[str, str | None] = {}
    candidates = robot.candidates()
    named = {
        stream: None if wanted == [NO_TOPIC] else _first_candidate(stream, wanted, listed, faults, notes)
        for stream, wanted in candidates.items()
        if wanted
    }
    faults += _read_twice(named, robot.source_frames())
    for stream in candidates:
        if stream in named:
            chosen[stream] = named[stream]
        elif row_of(stream).name == "camera_info":
            image = chosen[further("camera", sensor_of(stream)) if sensor_of(stream) else "camera"]
            chosen[stream] = _camera_info_of(stream, image, listed, notes)
        else:
            chosen[stream] = _best_by_name(stream, _without(listed, named, robot.source_frames()), notes)
    notes += [
        Note(
            "topics.planar-scan",
            f"{stream}: {topic} is a planar scan: its clouds are a line of points at the scanner's height",
        )
        for stream, topic in chosen.items()
        if topic is not None and row_of(stream).name == "lidar" and MESSAGES[listed[topic].type].planar
    ]
    if faults:
        raise DatasetsError("; ".join(faults), where="topics", cure="correct the robot's candidate topics")
    transforms = tuple(sorted(t.name for t in listed.values() if t.type in proposed_types(TRANSFORMS) and t.count > 0))
    streams = {stream: topic for stream, topic in chosen.items() if topic is not None}
    return TopicMap(
        streams=streams,
        transforms=transforms,
        not_used=unused_topics(topics, chosen, transforms),
        notes=tuple(notes),
        further=propose_further(listed, streams),
    )


def _listed(topics: Sequence[Topic]) -> dict[str, Topic]:
    """The topics by name; one that carries messages of several types cannot feed a stream and is left out."""
    carrying = Counter(topic.name for topic in topics if topic.count > 0)
    return {topic.name: topic for topic in topics if carrying[topic.name] == (1 if topic.count else 0)}


def _read_twice(named: Mapping[str, str | None], frames: Mapping[str, str]) -> list[str]:
    """Faults of topics that are to feed two cameras, or two LiDARs, whose frames do not tell them apart."""
    streams: dict[str, list[str]] = {}
    for stream, topic in named.items():
        if topic is not None and is_large(stream):
            streams.setdefault(topic, []).append(stream)
    several = {topic: both for topic, both in streams.items() if len({frames.get(x, "") for x in both}) < len(both)}
    return [f"{' and '.join(both)} are both {topic}" for topic, both in several.items()]


def _without(
    listed: Mapping[str, Topic], named: Mapping[str, str | None], frames: Mapping[str, str]
) -> dict[str, Topic]:
    """The topics that no further camera or LiDAR is read from, in whatever encoding; one of several by frame may be."""
    further_ones = {stream: topic for stream, topic in named.items() if topic is not None and sensor_of(stream)}
    taken = {camera_name(topic) for stream, topic in further_ones.items() if stream not in frames}
    return {name: topic for name, topic in listed.items() if camera_name(name) not in taken}


def _first_candidate(
    stream: str, wanted: Sequence[str], listed: Mapping[str, Topic], faults: list[str], notes: list[Note]
) -> str | None:
    empty: list[str] = []
    readable, proposed = readable_types(row_of(stream).name), proposed_types(row_of(stream).name)
    for candidate in wanted:
        for name in _matches(candidate, listed):
            topic = listed[name]
            if topic.type not in readable:
                faults.append(f"{stream}: {name} is {topic.type}, wanted {' or '.join(readable)}")
            elif topic.count == 0:
                empty.append(name)
            else:
                return name
    found = f"; {', '.join(empty)} without messages" if empty else ""
    others = sorted(t.name for t in listed.values() if t.type in proposed and t.count > 0)
    hint = f"; by type it could be {', '.join(others)}" if others else ""
    notes.append(Note("topics.none-of-them", f"{stream}: the recording has none of {', '.join(wanted)}{found}{hint}"))
    return None


def _matches(candidate: str, listed: Mapping[str, Topic]) -> list[str]:
    if candidate.startswith("/"):
        return [candidate] if candidate in listed else []
    return sorted((name for name in listed if f"/{name}".endswith(f"/{candidate}")), key=lambda name: (len(name), name))


def _best_by_name(stream: str, listed: Mapping[str, Topic], notes: list[Note]) -> str | None:
    scored = [
        (MESSAGES[topic.type].planar, -score, _transport_rank(topic.name, topic.type), len(topic.name), topic.name)
        for topic in listed.values()
        if topic.type in proposed_types(stream) and topic.count > 0
        if (score := STREAMS[stream].hints.score(topic.name)) is not None
    ]
    if not scored:
        return None
    (planar, cost, _, _, name), *others = sorted(scored)
    if cost > 0:
        what = f"{stream}: {name} is taken for its type alone, its name hints at something else"
        notes.append(Note("topics.by-type-alone", what))
    elif others and others[0][:2] == (planar, cost) and camera_name(others[0][-1]) != camera_name(name):
        what = f"{stream}: {name} and {others[0][-1]} fit equally; name one in the robot file"
        notes.append(Note("topics.equal", what))
    return name


def _transport_rank(name: str, kind: str) -> int:
    """Raw before compressed before video of the same sensor: what was lost in encoding does not come back."""
    return (
        int(MESSAGES[kind].video)
        + 2 * int(MESSAGES[kind].packed)
        + int(kind != proposed_types("camera")[0] or camera_name(name) != name)
    )


def _camera_info_of(stream: str, image: str | None, listed: Mapping[str, Topic], notes: list[Note]) -> str | None:
    infos = sorted(t.name for t in listed.values() if t.type in proposed_types("camera_info") and t.count > 0)
    if image is None or not infos:
        return None
    for namespace in camera_namespaces(image):
        if f"{namespace}/camera_info" in infos:
            return f"{namespace}/camera_info"
    cameras = {camera_name(t.name) for t in listed.values() if t.type in proposed_types("camera") and t.count > 0}
    if len(infos) == 1 and len(cameras) == 1:
        notes.append(
            Note("topics.only-calibration", f"{stream}: {infos[0]} is the only calibration, taken for {image}")
        )
        return infos[0]
    what = f"{stream}: none in the namespace of {image}; the recording has {', '.join(infos)}"
    notes.append(Note("topics.other-calibrations", what))
    return None
