"""Which settings of a composed configuration their dataclasses refuse, by the keys that a user writes."""

from collections.abc import Iterator

from omegaconf import DictConfig, ListConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from navtool.base.setting_error import Fault, SettingError, dotted


def refused_settings(composed: object, group: str = "") -> list[Fault]:
    """What the innermost dataclasses that refuse their values say, with the whole keys; none where none does.

    Args:
        composed: The configuration, or a group of it.
        group: What the group is called.
    """
    if not isinstance(composed, DictConfig | ListConfig):
        return []
    faults = [fault for key, inner in _groups(composed, group) for fault in refused_settings(inner, key)]
    if faults:
        return faults
    try:
        OmegaConf.to_object(composed)
    except OmegaConfBaseException:
        return []
    except SettingError as error:
        return list(error.below(group).faults)
    return []


def _groups(node: DictConfig | ListConfig, group: str) -> Iterator[tuple[str, object]]:
    """The groups of settings in a group, by their whole keys."""
    numbered = isinstance(node, ListConfig)
    for key in range(len(node)) if numbered else list(node):
        if not OmegaConf.is_missing(node, key):
            yield f"{group}[{key}]" if numbered else dotted(group, str(key)), node[key]
