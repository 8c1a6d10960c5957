"""Clocks compared by the robot's motion: what turned when, by gyroscope, odometry, clouds and pictures.

Gyroscope and odometry lie in memory and are always compared. Clouds and pictures are decoded again for it, a bounded
number of them, only of a stream whose clock is suspect, or where the settings ask.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from navtool.base.note import Note
from navtool.datasets.recording import Recording
from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.clock_offsets import OFFSET, SUSPECT_S, SUSPECTED, ClockOffset, Shift
from navtool.datasets.streams.clocks import Clocks
from navtool.datasets.streams.sensor_turning import sensor_turning
from navtool.datasets.streams.table import is_large, row_of
from navtool.datasets.streams.timed_stream import TimedStream, unit_quaternions
from navtool.pipeline.geometry.transforms import yaw_from_quaternion
from navtool.pipeline.time_offset import TimeOffset, Turning, busiest, time_offset

_REACH_S = 3.0
_LONGEST_S = 300.0
"""The busiest part of a longer recording is compared."""
_LOOKED_AT_S = 40.0
"""So much of clouds and pictures is decoded."""
_AGREE_S = 0.15
"""Motion and times of record say the same where they are no further apart: a latency lies between the two."""


@dataclass(frozen=True, slots=True)
class Measured:
    """What the robot's motion says of a stream's clock, after the times of record had been compared."""

    against: str
    """The stream that it was compared with."""
    offset: TimeOffset

    def __str__(self) -> str:
        """For a person."""
        found = self.offset
        return f"{found.lag_s:+.3f} s within {found.sd_s:.3f} s, correlation {abs(found.correlation):.2f}"


@dataclass(frozen=True, slots=True)
class MeasuredClocks:
    """The clocks once motion was compared, and what that gave by stream."""

    clocks: Clocks
    measured: Mapping[str, Measured]


def measure_offsets(
    recording: Recording,
    topics: Mapping[str, str],
    clocks: Clocks,
    times: Mapping[str, StreamTime],
    small: Mapping[str, TimedStream],
) -> MeasuredClocks:
    """The clocks, those that are apart by the robot's motion shifted, and suspicions that motion refutes taken back.

    Args:
        topics: By stream.
        times: Of every stream, on one clock.
        small: IMU and odometry in the base frame's axes.

    Raises:
        DatasetsError: A clock is apart, and the policy refuses that.
    """
    origin_ns = min((int(small[name].time.stamps_ns[0]) for name in ("imu", "odometry") if name in small), default=0)
    turnings = _turnings(small, origin_ns)
    measured: dict[str, Measured] = {}
    if len(turnings) == 2 and (found := _compared(turnings["imu"], turnings["odometry"])) is not None:
        measured["odometry"] = Measured("imu", found)
        clocks = _settled_pair(clocks, measured["odometry"])
    against = next((name for name in ("imu", "odometry") if name in turnings and not _apart(clocks, name)), None)
    if against is not None:
        for name in [name for name in clocks.header_ns if _wanted(clocks, name)]:
            start_s, end_s = busiest(turnings[against], _LOOKED_AT_S)
            span_ns = (origin_ns + round((start_s - _REACH_S) * 1e9), origin_ns + round((end_s + _REACH_S) * 1e9))
            turning = sensor_turning(recording, topics[name], clocks.record_ns[name], times[name], span_ns, origin_ns)
            found = None if turning is None else _compared(turnings[against], turning)
            if found is not None:
                measured[name] = Measured(against, found)
                clocks = _settled(clocks, name, measured[name])
    return MeasuredClocks(clocks, measured)


def _turnings(small: Mapping[str, TimedStream], origin_ns: int) -> dict[str, Turning]:
    """How far the robot turned to the left, by its gyroscope and by its odometry; times in seconds from the origin."""
    found: dict[str, Turning] = {}
    if "imu" in small:
        rate = small["imu"].columns("wz_radps")[:, 0]
        finite = np.isfinite(rate)
        time_s, rate = (small["imu"].time.stamps_ns[finite] - origin_ns) * 1e-9, rate[finite]
        steps = np.diff(time_s) * (rate[1:] + rate[:-1]) / 2
        found["imu"] = Turning(time_s, np.concatenate([[0.0], np.cumsum(steps)])[: time_s.size])
    if "odometry" in small:
        known = np.asarray(np.isfinite(small["odometry"].values).all(axis=1))
        yaw = np.unwrap(yaw_from_quaternion(unit_quaternions(small["odometry"])[known]))
        found["odometry"] = Turning((small["odometry"].time.stamps_ns[known] - origin_ns) * 1e-9, yaw)
    return {name: turning for name, turning in found.items() if turning.time_s.size > 2}


def _compared(first: Turning, second: Turning) -> TimeOffset | None:
    """The lag of the second behind the first."""
    start_s, end_s = busiest(first, _LONGEST_S)
    parts = []
    for turning, margin_s in ((first, 0.0), (second, _REACH_S)):
        inside = (turning.time_s >= start_s - margin_s) & (turning.time_s <= end_s + margin_s)
        if inside.sum() < 3:
            return None
        parts.append(Turning(turning.time_s[inside], turning.angle_rad[inside]))
    return time_offset(parts[0], parts[1], _REACH_S)


def _apart(clocks: Clocks, stream: str) -> bool:
    """Whether a stream's clock is suspect, and was left as it is."""
    offset = clocks.offsets.get(stream)
    return offset is not None and offset.shift is None and offset.note is not None


def _wanted(clocks: Clocks, stream: str) -> bool:
    if not is_large(stream) or clocks.policy.offset_of(stream) is not None:
        return False
    return clocks.policy.measure or stream in clocks.offsets


def _settled_pair(clocks: Clocks, measured: Measured) -> Clocks:
    """What the odometry's lag behind the gyroscope says of the two."""
    lag_s = measured.offset.lag_s
    suspects = [name for name in ("imu", "odometry") if _apart(clocks, name)]
    if abs(lag_s) <= SUSPECT_S:
        # Together they are right, or late alike; a motion that both show tells no more.
        return clocks if len(suspects) == 2 else _cleared(clocks, suspects)
    if len(suspects) == 1:
        sign = 1.0 if suspects[0] == "odometry" else -1.0
        offset = measured.offset._replace(lag_s=sign * lag_s)
        against = "odometry" if suspects[0] == "imu" else "imu"
        return _settled(clocks, suspects[0], Measured(against, offset))
    if "imu" in clocks.offsets or "odometry" in clocks.offsets:
        return clocks
    text = (
        f"shows the robot's turning {_when(lag_s)} the imu ({measured}), though the times of record do not: one of the "
        f"two is filtered or stamped late; they stay as they are, sync.odometry.offset_s={-lag_s:.3f} shifts it"
    )
    return clocks.shifted("odometry", ClockOffset(lag_s, None, Note(SUSPECTED, text)))


def _settled(clocks: Clocks, stream: str, measured: Measured) -> Clocks:
    """What a stream's lag behind another says of its clock."""
    lag_s, known = measured.offset.lag_s, clocks.offsets.get(stream)
    if known is not None and known.shift is not None:
        return _refined(clocks, stream, known.shift, measured)
    if abs(lag_s) <= SUSPECT_S:
        return _cleared(clocks, [stream])
    if known is not None and abs(lag_s - known.apart_s) <= _AGREE_S:
        text = (
            f"its header clock is {_side(lag_s)} that of {measured.against} by the robot's turning ({measured}); its "
            "stamps were shifted"
        )
        return clocks.shifted(stream, ClockOffset(lag_s, Shift(-lag_s), Note(OFFSET, text)))
    text = (
        f"shows the robot's turning {_when(lag_s)} {measured.against} ({measured}), which the times of record do not "
        f"say; its stamps stay as they are, {clocks.policy.key_of(stream)}.offset_s={-lag_s:.3f} shifts them"
    )
    return clocks.shifted(stream, ClockOffset(lag_s, None, Note(SUSPECTED, text)))


def _refined(clocks: Clocks, stream: str, shift: Shift, measured: Measured) -> Clocks:
    """A shift by the times of record, up to a latency, made exact by motion; differences that are exact stay."""
    lag_s = measured.offset.lag_s
    if shift.exact or abs(lag_s) > row_of(stream).late_s:
        return clocks
    finer = replace(shift, seconds=shift.seconds - lag_s)
    text = (
        f"its header clock is {_side(-finer.seconds)} the others' by the times of record and the robot's turning "
        f"({measured} against {measured.against}); its stamps were shifted"
    )
    return clocks.shifted(stream, ClockOffset(-finer.seconds, finer, Note(OFFSET, text)))


def _cleared(clocks: Clocks, streams: list[str]) -> Clocks:
    """The clocks without a suspicion of these streams: they are late, and their stamps are right."""
    offsets = {name: offset for name, offset in clocks.offsets.items() if name not in streams}
    return replace(clocks, offsets=offsets)


def _side(lag_s: float) -> str:
    return f"{abs(lag_s):.3f} s {'ahead of' if lag_s > 0 else 'behind'}"


def _when(lag_s: float) -> str:
    """When a stream shows a motion by its own stamps: after another one where its clock is ahead."""
    return f"{abs(lag_s):.3f} s {'after' if lag_s > 0 else 'before'}"
