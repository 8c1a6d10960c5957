"""What a stop or intervention flag means: drivers also publish flags of which true is good."""

import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Bool

from navtool.base.note import Note
from navtool.datasets.streams.timed_stream import TimedStream
from navtool.pipeline.arrays import Array

INVERTED = "flag.inverted"
"""Code of the notes that say which way a flag counts."""

_GOOD = re.compile(
    r"(?<![a-z])(ok|okay|released?|healthy|clear(ed)?|ready|normal|safe|inactive|alive|good|off)(?![a-z])"
)
_ENABLED = re.compile(r"(?<![a-z])(enabled?|armed)(?![a-z])")
_STOP = re.compile(r"e_?stop|emergency|(?<![a-z])stop")
_MOVES_M = 0.05
"""So far within half a second a robot goes that moves."""
_HALF_STEP_NS = 250_000_000
_LEAST_MOVING_S = 3.0
_NEARLY_ALL = 0.9


def says_good(topic: str) -> bool:
    """Whether a flag's name says that true is good: ``/e_stop_ok``, ``/emergency_stop/released``."""
    name = topic.lower()
    return bool(_GOOD.search(name) or (_ENABLED.search(name) and _STOP.search(name)))


def with_flag_sense(
    small: Mapping[str, TimedStream], *, inverted: bool | None
) -> tuple[dict[str, TimedStream], list[Note]]:
    """The small streams with an intervention flag that is true while somebody intervenes, and what was done about it.

    A flag whose name says that true is good is inverted. One that is true nearly all the time in which the robot moves
    cannot mean what its name says: a stop is inverted if it changes at all, another flag is left out.

    Args:
        inverted: As the robot file has it; None leaves it to the name and the motion.
    """
    flag = small.get("intervention")
    if flag is None:
        return dict(small), []
    if inverted is not None:
        return dict(small) | {"intervention": _inverted(flag) if inverted else flag}, []
    topic, by_name = flag.recorded.topic, says_good(flag.recorded.topic)
    active = (flag.values[:, 0] > 0.5) != by_name
    share = _share_while_moving(flag, active, small.get("odometry"))
    by_hand = "robot.intervention.inverted=true or false says which way it counts"
    if share is None or share <= _NEARLY_ALL:
        if not by_name:
            return dict(small), []
        text = f"intervention: by its name {topic} is true while all is well; it is inverted; {by_hand}"
        return dict(small) | {"intervention": _inverted(flag)}, [Note(INVERTED, text)]
    seen = f"intervention: {topic}{', inverted by its name,' if by_name else ''} is true in {share:.0%} of the time in "
    seen += "which the robot moves"
    if active.all() or not (by_name or _STOP.search(topic.lower())):
        left = {name: stream for name, stream in small.items() if name != "intervention"}
        return left, [Note("flag.left-out", f"{seen}; it is left out; {by_hand}")]
    if by_name:
        return dict(small), [Note(INVERTED, f"{seen}; it is taken as recorded; {by_hand}")]
    return dict(small) | {"intervention": _inverted(flag)}, [Note(INVERTED, f"{seen}; it is inverted; {by_hand}")]


def _inverted(flag: TimedStream) -> TimedStream:
    return replace(flag, values=np.where(np.isfinite(flag.values), 1.0 - flag.values, flag.values))


def _share_while_moving(flag: TimedStream, active: Bool[Array, " n"], odometry: TimedStream | None) -> float | None:
    """Share of the time in which the robot moves that a flag is up; None where it hardly moves."""
    if odometry is None or not active.size:
        return None
    known = np.asarray(np.isfinite(odometry.values).all(axis=1))
    stamps_ns, position = odometry.time.stamps_ns[known], odometry.columns("x_m", "y_m")[known]
    if stamps_ns.size < 3:
        return None
    before, after = (
        np.searchsorted(stamps_ns, stamps_ns + side * _HALF_STEP_NS).clip(max=stamps_ns.size - 1) for side in (-1, 1)
    )
    at = np.searchsorted(flag.time.stamps_ns, stamps_ns, side="right") - 1
    moving = (np.linalg.norm(position[after] - position[before], axis=1) > _MOVES_M) & (at >= 0)
    seconds = np.minimum(np.gradient(stamps_ns * 1.0) * 1e-9, 1.0)
    moved_s = float(seconds[moving].sum())
    return float(seconds[moving & active[at]].sum()) / moved_s if moved_s >= _LEAST_MOVING_S else None
