"""Which setting of a composed configuration its dataclass refuses, by the key that a user writes."""

import re
from collections.abc import Iterator
from typing import NamedTuple

from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from navtool.base.errors import NavtoolError

_FIRST_WORD = re.compile(r"[\w.]+")


class Refusal(NamedTuple):
    """What is wrong with a setting."""

    where: str | None
    """Dotted key of the setting or of its group; None where the text begins with it."""
    what: str
    cure: str | None


def refusal(composed: object) -> Refusal | None:
    """What the innermost dataclass that refuses its values says, with the whole key; None where none does."""
    return _refusal(composed, "")


def dotted(group: str, key: str) -> str:
    """A key as it is called in its group, or from further above, as it is called from the top.

    ``robot.topics`` and ``topics.imu`` are ``robot.topics.imu``; ``drive`` and ``duration_s`` are ``drive.duration_s``.
    """
    above, own = group.split(".") if group else [], key.split(".")
    shared = next(n for n in range(len(above), -1, -1) if n <= len(own) and above[len(above) - n :] == own[:n])
    return ".".join([*above, *own[shared:]])


def _refusal(node: object, group: str) -> Refusal | None:
    if not isinstance(node, DictConfig | ListConfig):
        return None
    for key, inner in _groups(node):
        place = f"{group}[{key}]" if isinstance(node, ListConfig) else f"{group}.{key}" if group else str(key)
        if (found := _refusal(inner, place)) is not None:
            return found
    try:
        OmegaConf.to_object(node)
    except OmegaConfBaseException:
        return None
    except NavtoolError as error:
        return Refusal(dotted(group, error.where) if error.where else group or None, error.what, error.cure)
    except ValueError as error:
        return _of_text(str(error), node, group)
    return None


def _of_text(text: str, node: DictConfig | ListConfig, group: str) -> Refusal:
    word = _FIRST_WORD.match(text)
    if word is not None and ("." in word[0] or (isinstance(node, DictConfig) and word[0] in node)):
        return Refusal(None, dotted(group, word[0]) + text[word.end() :], None)
    return Refusal(group or None, text, None)


def _groups(node: DictConfig | ListConfig) -> Iterator[tuple[str | int, object]]:
    """The groups of settings in a group."""
    keys = range(len(node)) if isinstance(node, ListConfig) else list(node)
    for key in keys:
        if not OmegaConf.is_missing(node, key):
            yield key, node[key]
