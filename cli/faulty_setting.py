"""Which setting of a composed configuration its dataclass refuses, by the key that a user writes."""

from collections.abc import Iterator

from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from navtool.base.errors import NavtoolError
from navtool.base.refusal import Refusal


def refusal(composed: object) -> Refusal | None:
    """What the innermost dataclass that refuses its values says, with the whole key; None where none does."""
    return _refusal(composed, "")


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
    except (NavtoolError, ValueError) as error:
        return Refusal.of(error, group, list(map(str, node)) if isinstance(node, DictConfig) else ())
    return None


def _groups(node: DictConfig | ListConfig) -> Iterator[tuple[str | int, object]]:
    """The groups of settings in a group."""
    keys = range(len(node)) if isinstance(node, ListConfig) else list(node)
    for key in keys:
        if not OmegaConf.is_missing(node, key):
            yield key, node[key]
