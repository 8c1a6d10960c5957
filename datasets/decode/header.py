"""The head that most messages share."""

from typing import Any, NamedTuple

_NS_PER_S = 1_000_000_000


class Head(NamedTuple):
    """Stamp and frame of a message."""

    stamp_ns: int | None
    frame_id: str


NO_HEAD = Head(None, "")
"""Of a message whose type has no header."""


def head_of(message: Any) -> Head:
    """Stamp and frame of a message whose type has a header."""
    return Head(nanoseconds(message.header.stamp), message.header.frame_id)


def nanoseconds(time: Any) -> int:
    """A ``builtin_interfaces/Time`` or ROS 1 ``time`` as one number."""
    return int(time.sec) * _NS_PER_S + int(time.nanosec)
