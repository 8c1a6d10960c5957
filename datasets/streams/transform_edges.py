"""The transforms on /tf, edge by edge: which frame moved in which, and when."""

import struct
from array import array
from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64, Int64

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import Transform, TransformsSample
from navtool.datasets.recording import RawMessage, Recording
from navtool.datasets.streams.usual_layout import TRANSFORMS_LAYOUT
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_from_transform, transform_from_xyz_quaternion

_SAME = 1e-6
"""Numbers closer than this are the same transform, published again."""
_WIDTH = 7
_MOST = 1e9
_U32, _ROS1_HEAD, _CDR_HEAD = struct.Struct("<I"), struct.Struct("<IIII"), struct.Struct("<iII")
_POSE = struct.Struct("<7d")

type Edge = tuple[str, str]
"""Parent and child, without a leading slash."""


@dataclass(slots=True)
class EdgeSamples:
    """All that was published of one edge, in the order of record."""

    stamps_ns: array[int] = field(default_factory=lambda: array("q"))
    record_ns: array[int] = field(default_factory=lambda: array("q"))
    numbers: array[float] = field(default_factory=lambda: array("d"))

    @property
    def poses(self) -> Float64[Array, "n 7"]:
        """x, y, z in metres and x, y, z, w of the quaternion of the child in the parent."""
        return np.frombuffer(self.numbers, np.float64).reshape(-1, _WIDTH)

    @property
    def times_ns(self) -> tuple[Int64[Array, " n"], Int64[Array, " n"]]:
        """Stamps, and times of record."""
        return np.frombuffer(self.stamps_ns, np.int64), np.frombuffer(self.record_ns, np.int64)

    @property
    def moves(self) -> bool:
        """Whether it ever changes."""
        poses = self.poses
        # A quaternion and its negative are one attitude.
        same_sign = np.where((poses[:, 3:] @ poses[0, 3:] < 0)[:, None], -1.0, 1.0)
        return bool(
            (np.abs(poses[:, :3] - poses[0, :3]) > _SAME).any()
            or (np.abs(poses[:, 3:] * same_sign - poses[0, 3:]) > _SAME).any()
        )

    def transform(self, edge: Edge) -> Transform:
        """The first of them."""
        first = self.poses[0]
        matrix = transform_from_xyz_quaternion(first[:3], first[3:])
        return Transform(parent=edge[0], child=edge[1], stamp_ns=self.stamps_ns[0], matrix=matrix)


def read_edges(recording: Recording, topics: Collection[str]) -> dict[Edge, EdgeSamples]:
    """Everything that the topics say, by edge; what is no transform is left out.

    Memory holds 72 bytes for each transform.

    Raises:
        DatasetsError: The recording cannot be read on.
    """
    edges: dict[Edge, EdgeSamples] = {}
    fast = {topic.name: _FastTransforms.of(recording, topic.name, topic.type) for topic in recording.topics}
    for raw in recording.messages(topics):
        reader = fast[raw.topic]
        if reader is None or not reader.read(raw, edges):
            _decode(recording, raw, edges)
    return {edge: samples for edge, samples in edges.items() if samples.stamps_ns}


def _decode(recording: Recording, raw: RawMessage, edges: dict[Edge, EdgeSamples]) -> None:
    try:
        sample = recording.decode(raw)
    except DatasetsError:
        return
    for entry in sample.transforms if isinstance(sample, TransformsSample) else ():
        pose = (*entry.matrix[:3, 3].tolist(), *quaternion_from_transform(entry.matrix).tolist())
        _add(edges, (entry.parent.lstrip("/"), entry.child.lstrip("/")), entry.stamp_ns, raw.record_ns, pose)


def _add(edges: dict[Edge, EdgeSamples], edge: Edge, stamp_ns: int, record_ns: int, pose: tuple[float, ...]) -> None:
    if not all(abs(number) < _MOST for number in pose) or not any(pose[3:]):
        return
    samples = edges.setdefault(edge, EdgeSamples())
    samples.stamps_ns.append(stamp_ns)
    samples.record_ns.append(record_ns)
    samples.numbers.extend(pose)


class _FastTransforms:
    """Reads the usual messages straight from their bytes: robots publish dozens of edges hundreds of times a second."""

    def __init__(self, encoding: str) -> None:
        self._ros1 = encoding == "ros1"

    @classmethod
    def of(cls, recording: Recording, topic: str, kind: str) -> "_FastTransforms | None":
        """The reader of a topic; None where its messages are not the usual ones."""
        described = recording.layout_of(RawMessage(topic, kind, 0, b""))
        if described is None or described[1] != TRANSFORMS_LAYOUT.get(described[0]):
            return None
        return cls(described[0])

    def read(self, raw: RawMessage, edges: dict[Edge, EdgeSamples]) -> bool:
        """Add the transforms of a message; whether its bytes are what they should be."""
        if not self._ros1 and raw.data[:2] != b"\x00\x01":
            return False
        try:
            found = self._ros1_entries(raw.data) if self._ros1 else self._cdr_entries(raw.data)
        except (struct.error, UnicodeDecodeError):
            return False
        for edge, stamp_ns, pose in found:
            _add(edges, edge, stamp_ns, raw.record_ns, pose)
        return True

    def _ros1_entries(self, data: bytes) -> list[tuple[Edge, int, tuple[float, ...]]]:
        found, place = [], 4
        for _ in range(_U32.unpack_from(data)[0]):
            _, seconds, rest, size = _ROS1_HEAD.unpack_from(data, place)
            place += 16
            parent, place = data[place : place + size], place + size
            size = _U32.unpack_from(data, place)[0]
            place += 4
            child, place = data[place : place + size], place + size
            found.append((_edge(parent, child), seconds * 1_000_000_000 + rest, _POSE.unpack_from(data, place)))
            place += _POSE.size
        return found

    def _cdr_entries(self, data: bytes) -> list[tuple[Edge, int, tuple[float, ...]]]:
        found, place = [], 8
        for _ in range(_U32.unpack_from(data, 4)[0]):
            seconds, rest, size = _CDR_HEAD.unpack_from(data, place)
            place += 12
            parent, place = data[place : place + size - 1], place + size
            place += -place % 4
            size = _U32.unpack_from(data, place)[0]
            place += 4
            child, place = data[place : place + size - 1], place + size
            place += (4 - place) % 8
            found.append((_edge(parent, child), seconds * 1_000_000_000 + rest, _POSE.unpack_from(data, place)))
            place += _POSE.size
        return found


def _edge(parent: bytes, child: bytes) -> Edge:
    return parent.decode().lstrip("/"), child.decode().lstrip("/")
