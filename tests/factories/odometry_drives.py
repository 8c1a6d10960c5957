"""Odometry of drives whose true motion is known, sound or spoilt in the ways that recordings are."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from navtool.datasets.streams.clock import StreamTime
from navtool.datasets.streams.recorded_stream import RecordedStream
from navtool.datasets.streams.rows import ODOMETRY_COLUMNS
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array

LINEAR, ANGULAR, FORWARD, LEFT, TURN = slice(7, 10), slice(10, 13), 7, 8, 12
"""Columns of an odometry."""
START_NS = 1_700_000_000_000_000_000
_STEP_S = 0.002


class OdometryDrive(NamedTuple):
    """Odometry messages of a drive, and what is true."""

    time_s: Array
    values: Array
    """[n, 13] in the order of ``ODOMETRY_COLUMNS``."""
    truth: Array
    """[n, 3]: speed forward and to the left, turning rate."""

    def stream(self) -> TimedStream:
        """As the first pass reads it."""
        recorded = RecordedStream("/odom", rows=[tuple(row) for row in self.values.tolist()], columns=ODOMETRY_COLUMNS)
        stamps_ns = np.rint(self.time_s * 1e9).astype(np.int64)
        return TimedStream.of(recorded, StreamTime(stamps_ns, np.arange(stamps_ns.size), "header"))

    def spoilt(self, change: Callable[[Array, Array], None]) -> "OdometryDrive":
        """The same with its messages changed: by a function of time and values, in place."""
        values = self.values.copy()
        change(self.time_s, values)
        return self._replace(values=values)


def _mixed(t: Array) -> tuple[Array, Array, Array]:
    return 1.0 + 0.4 * np.sin(0.7 * t), 0 * t, 0.5 * np.sin(0.31 * t)


def _one_turn(t: Array) -> tuple[Array, Array, Array]:
    late = (t > 0.8 * t[-1]) & (t < 0.8 * t[-1] + 2)
    return 1.0 + 0 * t, 0 * t, np.where(late, np.pi / 4, 0.0)


def _lap(t: Array) -> tuple[Array, Array, Array]:
    turns = (t > 0.45 * t[-1]) & (t < 0.55 * t[-1])
    return np.where(turns, 0.0, 1.0), 0 * t, np.where(turns, np.pi / (0.1 * t[-1]), 0.0)


COURSES: dict[str, Callable[[Array], tuple[Array, Array, Array]]] = {
    "mixed": _mixed,
    "circle": lambda t: (1.0 + 0 * t, 0 * t, 0.4 + 0 * t),
    "straight": lambda t: (1.0 + 0 * t, 0 * t, 0 * t),
    "one-turn": _one_turn,
    "lap": _lap,
    "stand": lambda t: (0 * t, 0 * t, 0 * t),
    "rotation": lambda t: (0 * t, 0 * t, 0.6 * np.sign(np.sin(0.3 * t))),
    "reverse": lambda t: (-0.8 + 0.2 * np.sin(t), 0 * t, 0.3 * np.sin(0.4 * t)),
    "back-and-forth": lambda t: (np.sin(0.5 * t), 0 * t, 0.3 * np.sin(0.23 * t)),
    "sideways": lambda t: (0.4 * np.sin(0.5 * t) + 0.3, 0.5 * np.sin(0.37 * t), 0.3 * np.sin(0.23 * t)),
    "once-aside": lambda t: (0.5 + 0 * t, np.where((t > 20) & (t < 26), 0.5, 0.0), 0.2 * np.sin(0.3 * t)),
    "only-sideways": lambda t: (0 * t, 0.6 + 0 * t, 0.1 * np.sin(0.3 * t)),
}
"""Speeds forward and to the left and turning rate over time, by name."""


def _stop_and_go(t: Array) -> tuple[Array, Array, Array]:
    goes = np.where(t % 10 < 6, 1.0, 0.0)
    return 0.2 * goes, 0 * t, 0.35 * goes * np.sign(np.sin(0.2 * t))


SLOW: dict[str, Callable[[Array], tuple[Array, Array, Array]]] = {
    "creeping": lambda t: (0.08 + 0 * t, 0 * t, 0.3 * np.sin(0.31 * t)),
    "creeping-unsteadily": lambda t: (0.09 + 0.05 * np.sin(0.2 * t), 0 * t, 0.3 * np.sin(0.31 * t)),
    "stop-and-go": _stop_and_go,
    "hardly-turning": lambda t: (0.5 + 0 * t, 0 * t, 0.15 * np.sin(0.3 * t)),
}
"""Such as arms on wheels, tracked robots and those that turn in wide arcs drive."""


def odometry_drive(
    course: str,
    *,
    seconds: float = 40.0,
    hz: float = 20.0,
    yaw_rad: float = 0.3,
    noise_m: float = 0.0,
    noise_rad: float = 0.0,
    noise_mps: float = 0.0,
    jitter_s: float = 0.0,
) -> OdometryDrive:
    """A drive along a course, its velocities in the body's axes.

    Args:
        yaw_rad: Where it looks at first.
        noise_m: Of each position.
        noise_rad: Of each yaw.
        noise_mps: Of each velocity, in m/s and rad/s.
        jitter_s: Of the moments at which it is measured.
    """
    rng = np.random.default_rng(7)
    fine_s = np.arange(0.0, seconds + 1.0, _STEP_S)
    forward, left, turn = (np.asarray(part, np.float64) for part in (COURSES | SLOW)[course](fine_s))
    yaw = yaw_rad + _summed(turn)
    x = _summed(forward * np.cos(yaw) - left * np.sin(yaw))
    y = _summed(forward * np.sin(yaw) + left * np.cos(yaw))
    time_s = np.arange(0.0, seconds, 1 / hz)
    time_s = np.sort(np.abs(time_s + rng.normal(0, jitter_s, time_s.size)))
    at = [np.interp(time_s, fine_s, part) for part in (x, y, yaw, forward, left, turn)]
    values = np.zeros((time_s.size, len(ODOMETRY_COLUMNS)))
    values[:, :2] = np.column_stack(at[:2]) + rng.normal(0, noise_m, (time_s.size, 2))
    headings = at[2] + rng.normal(0, noise_rad, time_s.size)
    values[:, 3:7] = Rotation.from_euler("z", headings[:, None]).as_quat()
    values[:, [FORWARD, LEFT, TURN]] = np.column_stack(at[3:]) + rng.normal(0, noise_mps, (time_s.size, 3))
    return OdometryDrive(time_s, values, np.column_stack(at[3:]))


def _summed(rate: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / 2 * _STEP_S)])


def transforms_entry(
    time_s: float, edges: list[tuple[str, str, list[float]]], topic: str = "/tf", *, ros1: bool = False
) -> tuple[str, str, int, dict[str, Any]]:
    """A message of transforms: parent, child, and x, y, z with the quaternion (x, y, z, w)."""
    stamp = START_NS + round(time_s * 1e9)
    entries = [
        {
            "header": {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": parent},
            "child_frame_id": child,
            "transform": {
                "translation": dict(zip("xyz", pose[:3], strict=True)),
                "rotation": dict(zip("xyzw", pose[3:], strict=True)),
            },
        }
        for parent, child, pose in edges
    ]
    kind = "tf/msg/tfMessage" if ros1 else "tf2_msgs/msg/TFMessage"
    return topic, kind, stamp + 2_000_000, {"transforms": entries}


def into_parent(_: Array, values: Array) -> None:
    """Velocities in the axes of the poses' frame, as Gazebo's plug-ins and motion capture write them."""
    turn = Rotation.from_quat(values[:, 3:7])
    values[:, LINEAR], values[:, ANGULAR] = turn.apply(values[:, LINEAR]), turn.apply(values[:, ANGULAR])


def scaled(**factors: float) -> Callable[[Array, Array], None]:
    """Columns times factors: ``scaled(vx=3.6, vy=3.6)``."""
    places = {"vx": FORWARD, "vy": LEFT, "wz": TURN}

    def change(_: Array, values: Array) -> None:
        for name, factor in factors.items():
            values[:, places[name]] *= factor

    return change


def held(first_s: float, last_s: float, columns: slice, value: float | None = None) -> Callable[[Array, Array], None]:
    """Columns that keep one value, or that of the first moment, for a while."""

    def change(time_s: Array, values: Array) -> None:
        inside = (time_s >= first_s) & (time_s <= last_s)
        values[inside, columns] = values[np.argmax(inside), columns] if value is None else value

    return change


def jumping(every: int) -> Callable[[Array, Array], None]:
    """Poses that jump by some metres now and then, as satellites or a closed loop correct them."""

    def change(_: Array, values: Array) -> None:
        rng = np.random.default_rng(3)
        jumps = np.where(np.arange(len(values)) % every == every // 2, 1.0, 0.0)
        directions = rng.uniform(-np.pi, np.pi, len(values))
        lengths = jumps * rng.uniform(0.7, 3.0, len(values))
        values[:, :2] += np.cumsum(np.column_stack([np.cos(directions), np.sin(directions)]) * lengths[:, None], axis=0)

    return change


def odometry_entries(
    drive: OdometryDrive,
    *,
    frame: str = "odom",
    child: str = "base_link",
    topic: str = "/odom",
) -> list[tuple[str, str, int, dict[str, Any]]]:
    """The drive as messages on a topic, for a writer of recordings."""
    entries = []
    for time_s, row in zip(drive.time_s.tolist(), drive.values.tolist(), strict=True):
        stamp = START_NS + round(time_s * 1e9)
        header = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": frame}
        names = (("position", "xyz", 0), ("orientation", "xyzw", 3), ("linear", "xyz", 7), ("angular", "xyz", 10))
        parts = {name: {axis: row[at + k] for k, axis in enumerate(axes)} for name, axes, at in names}
        pose = {"position": parts["position"], "orientation": parts["orientation"]}
        twist = {"linear": parts["linear"], "angular": parts["angular"]}
        fields = {"header": header, "child_frame_id": child, "pose": {"pose": pose}, "twist": {"twist": twist}}
        entries.append((topic, "nav_msgs/msg/Odometry", stamp + 2_000_000, fields))
    return entries
