"""What a dataclass says of values that it refuses, by the key that a user writes."""

import re
from collections.abc import Collection
from typing import NamedTuple

from navtool.base.errors import NavtoolError

_FIRST_WORD = re.compile(r"[a-z_]\w*(\.\w+)*")


class Refusal(NamedTuple):
    """What is wrong with a setting."""

    where: str | None
    """Dotted key of the setting or of its group; None where the text begins with it, or the group is the whole."""
    what: str
    cure: str | None

    @classmethod
    def of(cls, error: NavtoolError | ValueError, group: str, names: Collection[str]) -> "Refusal":
        """What an error says, with the whole key of the setting.

        Args:
            error: Raised by a dataclass's own checks. Its place, or the first word of its text, may be the key of a
                setting, as its class calls it or as it is called from further above.
            group: Dotted key of the dataclass; empty for the whole.
            names: The dataclass's fields.
        """
        if isinstance(error, NavtoolError):
            return cls(dotted(group, error.where) if error.where else group or None, error.what, error.cure)
        text = str(error)
        word = _FIRST_WORD.match(text)
        if word is not None and (word[0] in names or "." in word[0]):
            return cls(None, dotted(group, word[0]) + text[word.end() :], None)
        return cls(group or None, text, None)


def dotted(group: str, key: str) -> str:
    """A key as it is called in its group, or from further above, as it is called from the top.

    ``robot.topics`` and ``topics.imu`` are ``robot.topics.imu``; ``drive`` and ``duration_s`` are ``drive.duration_s``.
    """
    above, own = group.split(".") if group else [], key.split(".")
    shared = next(n for n in range(len(above), -1, -1) if n <= len(own) and above[len(above) - n :] == own[:n])
    return ".".join([*above, *own[shared:]])
