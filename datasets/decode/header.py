"""The head that most messages share."""

from typing import Any, NamedTuple

from navtool.base.errors import DatasetsError

_NS_PER_S = 1_000_000_000


class Head(NamedTuple):
    """Stamp and frame of a message."""

    stamp_ns: int | None
    frame_id: str


NO_HEAD = Head(None, "")
"""The head of a message whose type has no header."""


def head_of(message: Any) -> Head:
    """Stamp and frame of a message whose type has a header."""
    return Head(nanoseconds(message.header.stamp), message.header.frame_id)


def nanoseconds(time: Any) -> int:
    """A ``builtin_interfaces/Time`` or ROS 1 ``time`` as one number."""
    return joined_ns(time.sec, time.nanosec)


def joined_ns(seconds: Any, nanoseconds: Any) -> int:
    """A time of two numbers as one.

    Raises:
        DatasetsError: It takes more than 63 bits, as schemas without types let it.
    """
    joined = int(seconds) * _NS_PER_S + int(nanoseconds)
    if abs(joined) >= 1 << 63:
        raise DatasetsError(f"a stamp of {seconds} s")
    return joined
