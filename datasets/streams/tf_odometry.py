"""Odometry out of the transforms, where no topic has it: how the robot's base moved in the odometry's frame."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from jaxtyping import Float64, Int64

from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.recorded_stream import RecordedStream, Source
from navtool.datasets.streams.rows import ODOMETRY_COLUMNS
from navtool.datasets.streams.sync import brackets
from navtool.datasets.streams.transform_edges import Edge, EdgeSamples
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import (
    quaternion_from_transform,
    slerp,
    transform_from_xyz_quaternion,
)

_BASES = ("base_link", "base_footprint", "base", "body", "base_stabilized", "chassis", "trunk")
"""What robots call their base, best first, behind what the robot file says."""
_LEAST = 2
_ANY_GAP_S = 1e9


@dataclass(frozen=True, slots=True)
class TfOdometry:
    """The odometry, and what it was made of.

    Attributes:
        stream: Poses without velocities.
        path: Its edges, from the odometry's frame down to the base.
        above: Edges over the odometry's frame, such as a localisation's.
    """

    stream: RecordedStream
    path: tuple[Edge, ...]
    above: tuple[Edge, ...]


def tf_odometry(edges: Mapping[Edge, EdgeSamples], robot: RobotConfig, topic: str) -> TfOdometry | None:
    """The odometry that moving transforms hold; None where none leads to the robot's base.

    The odometry's frame is the nearest one above the base whose name says odometry; where none does, the highest from
    which something moves. A localisation's edge above it (map to odom) jumps, and is no odometry.

    Args:
        edges: All that is known, static ones with a single sample.
    """
    parents = {child: parent for parent, child in edges}
    base = _base(edges, robot)
    if base is None:
        return None
    chain, seen = [base], {base}
    while chain[-1] in parents and parents[chain[-1]] not in seen:
        chain.append(parents[chain[-1]])
        seen.add(chain[-1])
    up = [(parent, child) for child, parent in pairwise(chain)]
    named = [number for number, (parent, _) in enumerate(up) if "odom" in _bare(parent)]
    moving = [number for number, edge in enumerate(up) if edges[edge].moves]
    if not named and not moving:
        return None
    path = up[: (named[0] if named else moving[-1]) + 1]
    stream = _composed([edges[edge] for edge in path], topic, base)
    return None if stream is None else TfOdometry(stream, tuple(reversed(path)), tuple(up[len(path) :]))


def _bare(frame: str) -> str:
    return frame.rsplit("/", 1)[-1].lower()


def _base(edges: Mapping[Edge, EdgeSamples], robot: RobotConfig) -> str | None:
    """The base's frame: as the robot file has it, in any one namespace, or one that is called as bases are."""
    children = sorted({child for _, child in edges})
    for name in (robot.base_frame.lstrip("/"), *_BASES):
        if name in children:
            return name
        ending = [child for child in children if child.endswith(f"/{name}")]
        if len(ending) == 1:
            return ending[0]
    return None


def _composed(path: list[EdgeSamples], topic: str, base: str) -> RecordedStream | None:
    """The poses at the stamps of the edge that moves furthest, the others between their own."""
    main = max(path, key=lambda samples: (samples.moves, float(np.ptp(samples.poses[:, :3], axis=0).sum())))
    stamps_ns, record_ns = main.times_ns
    if stamps_ns.size < _LEAST:
        return None
    pose = np.broadcast_to(np.eye(4), (stamps_ns.size, 4, 4))
    for samples in reversed(path):
        pose = pose @ (_matrices(samples.poses) if samples is main else _at(samples, stamps_ns))
    rows = np.zeros((stamps_ns.size, len(ODOMETRY_COLUMNS)))
    rows[:, :3], rows[:, 3:7] = pose[:, :3, 3], quaternion_from_transform(pose)
    stream = RecordedStream(topic, columns=ODOMETRY_COLUMNS, frame_id=base, rows=list(map(tuple, rows.tolist())))
    for stamp, recorded in zip(stamps_ns.tolist(), record_ns.tolist(), strict=True):
        stream.count(stamp, recorded, Source(base))
    return stream


def _matrices(poses: Float64[Array, "n 7"]) -> Float64[Array, "n 4 4"]:
    return transform_from_xyz_quaternion(poses[:, :3], poses[:, 3:])


def _at(samples: EdgeSamples, stamps_ns: Int64[Array, " k"]) -> Float64[Array, "k 4 4"]:
    """An edge at other moments; before its first sample and behind its last one it stays."""
    own_ns, first = np.unique(samples.times_ns[0], return_index=True)
    poses = samples.poses[first]
    if own_ns.size == 1:
        return np.broadcast_to(_matrices(poses)[0], (stamps_ns.size, 4, 4))
    around = brackets(own_ns, stamps_ns.clip(own_ns[0], own_ns[-1]), _ANY_GAP_S)
    attitude = slerp(poses[around.before, 3:], poses[around.after, 3:], around.weight)
    return transform_from_xyz_quaternion(around.linear(poses[:, :3]), attitude)
