"""Odometry whose velocities were compared with its poses, and mended where the poses tell how."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Bool, Float64

from navtool.base.note import Note
from navtool.datasets.robot.odometry_twist import OdometryTwist
from navtool.datasets.streams.pose_travel import POSE_COLUMNS, PoseTravel, pose_travel
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.datasets.streams.twist_columns import mend_columns
from navtool.datasets.streams.twist_comparison import APART, Witnesses
from navtool.datasets.streams.twist_frame import seconds_for_parent, turned_from_parent
from navtool.datasets.streams.twist_rows import Rows, compare_rows
from navtool.pipeline.arrays import Array

SPEEDS = ("vx_mps", "vy_mps", "wz_radps")
"""The velocities that are compared, in the order of a travel's columns."""
_PARTS = ("forward", "sideways", "turning")


@dataclass(frozen=True, slots=True)
class ComparedOdometry:
    """An odometry in the base frame.

    Attributes:
        stream: With velocities in m/s and rad/s along the body's axes; those that nothing can tell are NaN.
        notes: What was seen and done.
    """

    stream: TimedStream
    notes: list[Note] = field(default_factory=list)


def in_own_axes(odometry: TimedStream, wanted: OdometryTwist | None) -> ComparedOdometry:
    """The odometry as recorded, its velocities turned out of the axes of its poses' frame where they are in those.

    Args:
        wanted: What the robot's settings say; None looks.
    """
    if wanted is OdometryTwist.parent_frame:
        return ComparedOdometry(turned_from_parent(odometry))
    seconds = seconds_for_parent(odometry) if wanted is None else None
    if seconds is None:
        return ComparedOdometry(odometry)
    what = (
        "odometry: its velocities are in the axes of the frame of its poses, not in the robot's, as "
        f"{seconds[0]:.0f} of the {seconds[1]:.0f} s say in which the two differ; turned into the robot's"
    )
    return ComparedOdometry(turned_from_parent(odometry), [Note("odometry.parent-twist", what)])


def with_sound_twist(
    odometry: TimedStream, wanted: OdometryTwist | None, others: Mapping[str, TimedStream]
) -> ComparedOdometry:
    """The odometry in the base frame, its velocities mended column by column and row by row by its poses.

    Args:
        odometry: Poses and velocities of the base frame.
        wanted: What the robot's settings say; None compares.
        others: The other small streams in the base frame; commands and the IMU say which way the robot moves.
    """
    travel = pose_travel(odometry)
    if travel is None or wanted in (OdometryTwist.as_recorded, OdometryTwist.parent_frame):
        return ComparedOdometry(odometry)
    if wanted is OdometryTwist.from_poses:
        return ComparedOdometry(_with_speeds(odometry, travel, travel.speeds()))
    columns = mend_columns(odometry.columns(*SPEEDS)[travel.rows], travel, _witnesses(others, odometry, travel))
    compared = ~(columns.taken | columns.undecided) & np.nan_to_num(columns.speeds).any(axis=0)
    rows = compare_rows(columns.speeds, odometry.columns(*POSE_COLUMNS)[travel.rows], travel, compared)
    speeds = np.where(rows.stale, travel.speeds(), columns.speeds)
    speeds[rows.stopped] = np.nan
    notes = [*columns.notes, *_row_notes(rows, travel)]
    return ComparedOdometry(odometry if not notes else _with_speeds(odometry, travel, speeds), notes)


def twist_apart(odometry: TimedStream) -> list[Note]:
    """What velocities and poses of an ingested odometry say against each other: what ingest could not mend."""
    if not (np.diff(odometry.time.stamps_ns) > 0).all():
        return []
    return [note for note in with_sound_twist(odometry, None, {}).notes if note.code != "odometry.poses-jump"]


def _witnesses(others: Mapping[str, TimedStream], odometry: TimedStream, travel: PoseTravel) -> Witnesses:
    stamps_ns = odometry.time.stamps_ns[travel.rows]
    return Witnesses(_held(others.get("command"), "vx_mps", stamps_ns), _held(others.get("imu"), "wz_radps", stamps_ns))


def _held(stream: TimedStream | None, column: str, stamps_ns: Array) -> Float64[Array, " n"] | None:
    """A column at other moments: the value before each, 0 before the first; None where nothing moves."""
    if stream is None or column not in stream.recorded.columns:
        return None
    values = np.nan_to_num(stream.columns(column)[:, 0])
    if not values.any():
        return None
    at = np.searchsorted(stream.time.stamps_ns, stamps_ns, side="right") - 1
    return np.where(at >= 0, values[at.clip(min=0)], 0.0)


def _with_speeds(odometry: TimedStream, travel: PoseTravel, speeds: Float64[Array, "n 3"]) -> TimedStream:
    values = odometry.values.copy()
    places = [odometry.recorded.columns.index(name) for name in SPEEDS]
    values[travel.rows[:, None], places] = speeds
    return replace(odometry, values=values)


def _row_notes(rows: Rows, travel: PoseTravel) -> list[Note]:
    notes = []
    jumps = int(travel.jumps.sum())
    stale, stopped, apart = _some(rows.stale), rows.stopped, _some(rows.apart)
    if stale.any():
        what = (
            f"odometry: {_parts(rows.stale)} does not change in {_share(stale)} while the poses say another one; "
            "taken from the poses there"
        )
        notes.append(Note("odometry.twist-stale", what))
    if stopped.any():
        what = (
            f"odometry: the poses do not change in {_share(stopped)} while its velocities say that the robot moves; "
            "not valid there"
        )
        notes.append(Note("odometry.poses-stopped", what))
    if jumps:
        largest = "once" if jumps == 1 else f"{jumps} times"
        what = f"odometry: the poses jump {largest}, without a velocity; the jumps count for no speed"
        notes.append(Note("odometry.poses-jump", what))
    if apart.any():
        what = (
            f"odometry: {_parts(rows.apart)} by its velocities is another one than by its poses in {_share(apart)}, "
            "and nothing tells which is right; kept as recorded"
        )
        notes.append(Note(APART, what))
    return notes


def _some(flags: Bool[Array, "n columns"]) -> Bool[Array, " n"]:
    return np.asarray(flags.any(axis=1))


def _parts(flags: Bool[Array, "n 3"]) -> str:
    found = [part for part, flagged in zip(_PARTS, _some(flags.T).tolist(), strict=True) if flagged]
    return f"the speed {' and '.join(found)}".replace("speed turning", "turning rate").replace(
        "and turning", "and the turning rate"
    )


def _share(rows: Bool[Array, " n"]) -> str:
    return f"{int(rows.sum())} of {rows.size} messages"
