"""In whose axes an odometry's velocities are: the body's, as ROS has it, or those of the frame of its poses."""

from dataclasses import replace

import numpy as np
from jaxtyping import Bool, Complex128, Float64

from navtool.datasets.streams.pose_travel import PoseTravel, pose_travel
from navtool.datasets.streams.timed_stream import TimedStream, unit_quaternions
from navtool.datasets.streams.twist_windows import summed, windows
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion

_LEAST_WINDOWS = 1.5
"""The two have to differ for so many windows on end."""
_APART = 0.3
"""They differ where their ways are so far apart, as a share of the way."""
_MOSTLY, _SELDOM = 0.8, 0.1
_LINEAR, _ANGULAR = ("vx_mps", "vy_mps", "vz_mps"), ("wx_radps", "wy_radps", "wz_radps")


def turned_from_parent(odometry: TimedStream) -> TimedStream:
    """The odometry with its velocities, which are in the axes of its poses' frame, turned into those of its body."""
    known = np.asarray(np.isfinite(odometry.columns("qx", "qy", "qz", "qw")).all(axis=1))
    turn = _attitudes(odometry, known)
    values = odometry.values.copy()
    for names in (_LINEAR, _ANGULAR):
        columns = [odometry.recorded.columns.index(name) for name in names]
        values[:, columns] = np.einsum("nji,nj->ni", turn, values[:, columns])
    return replace(odometry, values=values)


def seconds_for_parent(odometry: TimedStream) -> tuple[float, float] | None:
    """Seconds that speak for velocities in the parent frame, of those in which the two frames would differ.

    None where the velocities are the body's, or nothing tells: the robot stands or only ever looks one way, or neither
    frame gives the way of the poses. One turn of many straight minutes is enough.
    """
    travel = pose_travel(odometry)
    if travel is None or not np.nan_to_num(odometry.columns(*_LINEAR[:2])).any():
        return None
    found = windows(travel)
    least = found.least()[:, 0]
    poses = _plane(found.over(travel.way_m))
    body, parent = (_plane(found.over(way)) for way in _ways(odometry, travel))
    body = body * _turn_and_scale(poses, body, least)
    parent = parent * _turn_and_scale(poses, parent, least).real
    longest = np.max([np.abs(poses), np.abs(body), np.abs(parent)], axis=0)
    differ = (np.abs(body - parent) > _APART * longest) & (longest > least)
    if not differ.any() or differ.sum() * travel.period_s < _LEAST_WINDOWS * found.length_s.mean():
        return None
    error_body, error_parent = np.abs(poses - body)[differ], np.abs(poses - parent)[differ]
    fits = error_parent < _APART * longest[differ] + least[differ] / 2
    for_parent = (error_parent < error_body / 2) & fits
    if for_parent.mean() < _MOSTLY or (error_body < error_parent / 2).mean() > _SELDOM:
        return None
    return float(for_parent.sum() * travel.period_s), float(differ.sum() * travel.period_s)


def _ways(odometry: TimedStream, travel: PoseTravel) -> tuple[Float64[Array, "n 3"], Float64[Array, "n 3"]]:
    """Ways in the poses' frame, by velocities in the axes of the body, and in those of that frame."""
    linear = odometry.columns(*_LINEAR)[travel.rows]
    known = np.zeros(len(odometry.values), dtype=np.bool_)
    known[travel.rows] = True
    turned = np.einsum("nij,nj->ni", _attitudes(odometry, known)[travel.rows], np.nan_to_num(linear))
    return summed(turned, travel.time_s), summed(linear, travel.time_s)


def _plane(ways: Float64[Array, "windows columns"]) -> Complex128[Array, " windows"]:
    return np.asarray(ways[:, 0] + 1j * ways[:, 1])


def _turn_and_scale(
    poses: Complex128[Array, " windows"], way: Complex128[Array, " windows"], least_m: Float64[Array, " windows"]
) -> complex:
    """The number by which a way is multiplied to become that of the poses: their middle turn and scale."""
    moves = (np.abs(poses) > least_m) & (np.abs(way) > 1e-9)
    if not moves.any():
        return 1.0 + 0.0j
    ratio = poses[moves] / way[moves]
    middle = np.sum(ratio / np.abs(ratio) * np.abs(poses[moves]))
    turn = middle / abs(middle) if abs(middle) > 0 else 1.0
    return complex(np.median(np.abs(ratio)) * turn)


def _attitudes(odometry: TimedStream, known: Bool[Array, " kept"]) -> Float64[Array, "kept 3 3"]:
    quaternions = np.where(known[:, None], unit_quaternions(odometry), (0.0, 0.0, 0.0, 1.0))
    return np.asarray(transform_from_xyz_quaternion(np.zeros((len(quaternions), 3)), quaternions)[:, :3, :3])
