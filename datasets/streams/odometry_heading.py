"""Which way an odometry's body looks: turned where the robot says so, and noted where it seems to look aside."""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from navtool.base.note import Note
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import yaw_from_quaternion

ASIDE = "odometry.moves-aside"
"""Code of the notes that say that a robot moves aside of where its poses look."""

_ATTITUDE = ("qx", "qy", "qz", "qw")
_STEP_S = 1.0
"""Travel is measured over so long: the noise of a pose is small against it."""
_LEAST_STEP_M = 0.3
_LEAST_TRAVEL_M = 5.0


def turned_odometry(odometry: TimedStream, yaw_rad: float) -> TimedStream:
    """The odometry with a yaw added to its attitudes, in the body's own frame; positions and velocities stay.

    Args:
        odometry: Poses and velocities; an attitude that was never set (all zeros) stays so.
        yaw_rad: Where the base frame's x looks in the axes of the odometry's body.
    """
    if yaw_rad == 0.0:
        return odometry
    sine, cosine = np.sin(yaw_rad / 2), np.cos(yaw_rad / 2)
    x, y, z, w = odometry.columns(*_ATTITUDE).T
    turned = (cosine * x + sine * y, cosine * y - sine * x, cosine * z + sine * w, cosine * w - sine * z)
    values = odometry.values.copy()
    values[:, [odometry.recorded.columns.index(name) for name in _ATTITUDE]] = np.column_stack(turned)
    return replace(odometry, values=values)


def heading_notes(odometry: TimedStream | None) -> list[Note]:
    """Notes on an odometry by whose poses or velocities the robot moves more sideways than along.

    Nothing of one that moves less than 5 m, as much one way as the other, or without attitudes. A robot that walks
    sideways is noted as well: by its odometry alone the two look alike.
    """
    if odometry is None:
        return []
    attitude = odometry.columns(*_ATTITUDE)
    usable = np.isfinite(odometry.values).all(axis=1) & (np.linalg.norm(attitude, axis=1) > 1e-6)
    stamps_ns = odometry.time.stamps_ns[usable]
    if stamps_ns.size < 2:
        return []
    step_ns = round(_STEP_S * 1e9)
    # Steps that have poses: a stamp that is years away makes no years of steps.
    begins = stamps_ns[0] + np.unique((stamps_ns - stamps_ns[0]) // step_ns) * step_ns
    begins = begins[begins <= stamps_ns[-1] - step_ns]
    start, middle, end = (np.searchsorted(stamps_ns, begins + after_ns) for after_ns in (0, step_ns // 2, step_ns))
    position = odometry.columns("x_m", "y_m")[usable]
    travel = _in_body(position[end] - position[start], yaw_from_quaternion(attitude[usable][middle]))
    measured = odometry.columns("vx_mps", "vy_mps")[usable][middle] * _STEP_S
    notes = []
    if (aside_rad := _aside(travel)) is not None:
        what = (
            f"odometry: the robot moves {_side(aside_rad)} of where its poses look; if it does not walk sideways, its "
            f"odometry_yaw_rad lacks {aside_rad:.3f}"
        )
        notes.append(Note(ASIDE, what))
    if (aside_rad := _aside(measured)) is not None:
        what = f"state: the measured velocity points {_side(aside_rad)}; only its forward part is taken"
        notes.append(Note("state.velocity-aside", what))
    return notes


def _in_body(steps: Float64[Array, "n 2"], yaw_rad: Float64[Array, " n"]) -> Float64[Array, "n 2"]:
    """Horizontal vectors in the axes of a body: forward, left."""
    cosine, sine = np.cos(yaw_rad), np.sin(yaw_rad)
    return np.column_stack([steps[:, 0] * cosine + steps[:, 1] * sine, steps[:, 1] * cosine - steps[:, 0] * sine])


def _aside(steps: Float64[Array, "n 2"]) -> float | None:
    """Where steps in metres (forward, left) lead, taken together; None where they lead along, or nowhere."""
    length_m = np.linalg.norm(steps, axis=1)
    moves = length_m > _LEAST_STEP_M
    total_m = float(length_m[moves].sum())
    forward, left = steps[moves].sum(axis=0).tolist()
    if total_m < _LEAST_TRAVEL_M or np.hypot(forward, left) < total_m / 2 or abs(left) <= abs(forward):
        return None
    return float(np.arctan2(left, forward))


def _side(angle_rad: float) -> str:
    return f"{abs(np.degrees(angle_rad)):.0f} deg to the {'left' if angle_rad > 0 else 'right'}"
