"""What only the moving transforms say: odometry where no topic has it, and mounts that are on /tf alone."""

from collections.abc import Iterable
from dataclasses import replace

from navtool.base.note import Note
from navtool.datasets.decode.messages import Transform
from navtool.datasets.recording import Recording
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.robot.recorded_geometry import TransformTree, latest_transforms
from navtool.datasets.robot.topic_map import TopicMap
from navtool.datasets.streams.first_pass import FirstPass
from navtool.datasets.streams.table import in_order, row_of
from navtool.datasets.streams.tf_odometry import TfOdometry, tf_odometry
from navtool.datasets.streams.transform_edges import Edge, EdgeSamples, read_edges
from navtool.pipeline.geometry.transforms import quaternion_from_transform

_SHOWN = 5


def moving_topics(topics: TopicMap) -> tuple[str, ...]:
    """The topics of transforms that are not static."""
    return tuple(topic for topic in topics.transforms if not topic.endswith("tf_static"))


def may_hold_odometry(topics: TopicMap, robot: RobotConfig) -> bool:
    """Whether odometry may come from transforms: no topic has it, and the robot file says nothing of it."""
    return not robot.topics.odometry and "odometry" not in topics.streams and bool(moving_topics(topics))


def add_from_transforms(found: FirstPass, recording: Recording, robot: RobotConfig, *, odometry: bool = True) -> None:
    """Read the moving transforms where something is missing, and add what they hold to what the first pass found.

    Nothing is read where odometry has a topic and every sensor's frame is known from static transforms.

    Args:
        odometry: Whether odometry is wanted.

    Raises:
        DatasetsError: The recording cannot be read on.
    """
    topics = moving_topics(found.topics)
    wanted = odometry and "odometry" not in found.streams and may_hold_odometry(found.topics, robot)
    if not topics or not (wanted or _unplaced(found, robot)):
        return
    edges = read_edges(recording, topics)
    static, _ = latest_transforms(found.transforms)
    known = {(x.parent.lstrip("/"), x.child.lstrip("/")) for x in static}
    taken = None
    if wanted:
        fixed = {(x.parent.lstrip("/"), x.child.lstrip("/")): _single(x) for x in static}
        taken = tf_odometry({**fixed, **edges}, robot, topics[0])
    if taken is not None:
        found.streams["odometry"] = taken.stream
        found.streams = {name: found.streams[name] for name in in_order(found.streams)}
        streams = {**found.topics.streams, "odometry": topics[0]}
        found.topics = replace(found.topics, streams={name: streams[name] for name in in_order(streams)})
        found.notes.append(_odometry_note(taken, edges, topics[0]))
    path = set() if taken is None else {taken.path[0], *taken.above}
    mounts = [
        samples.transform(edge)
        for edge, samples in edges.items()
        if edge not in known and edge not in path and not samples.moves
    ]
    _add_mounts(found, robot, mounts, topics[0])


def _unplaced(found: FirstPass, robot: RobotConfig) -> list[str]:
    """The streams whose sensor's frame no transform joins to the base."""
    tree = TransformTree(latest_transforms(found.transforms)[0])
    return [
        name
        for name, stream in found.streams.items()
        if row_of(name).pose and stream.frame_id and tree.pose(robot.base_frame, stream.frame_id) is None
    ]


def _add_mounts(found: FirstPass, robot: RobotConfig, mounts: list[Transform], topic: str) -> None:
    before = _unplaced(found, robot)
    found.transforms += mounts
    placed = [name for name in before if name not in _unplaced(found, robot)]
    if placed:
        edges = _listed((x.parent, x.child) for x in mounts)
        what = f"tf: {edges} on {topic} never change: taken for mounting, of {', '.join(placed)}"
        found.notes.append(Note("tf.mount-moving-topic", what))


def _single(transform: Transform) -> EdgeSamples:
    samples = EdgeSamples()
    samples.stamps_ns.append(transform.stamp_ns)
    samples.record_ns.append(transform.stamp_ns)
    samples.numbers.extend((*transform.matrix[:3, 3].tolist(), *quaternion_from_transform(transform.matrix).tolist()))
    return samples


def _odometry_note(taken: TfOdometry, edges: dict[Edge, EdgeSamples], topic: str) -> Note:
    what = f"odometry: no topic has it; taken from {_listed(taken.path)} on {topic}"
    if above := [edge for edge in taken.above if edge in edges]:
        what += f"; {_listed(above)} is a localisation's, and no odometry"
    return Note("odometry.from-tf", what)


def _listed(edges: Iterable[Edge]) -> str:
    names = [f"{parent} -> {child}" for parent, child in edges]
    return ", ".join(names[:_SHOWN]) + (f" and {len(names) - _SHOWN} more" if len(names) > _SHOWN else "")
