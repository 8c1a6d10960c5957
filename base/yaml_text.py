"""YAML as people write it, read safely and strictly."""

from collections.abc import Hashable
from typing import Any, override

import yaml


class _StrictLoader(yaml.SafeLoader):
    """Refuses a key that stands twice in one mapping, of which YAML itself silently keeps the last."""

    @override
    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        # before `<<` is resolved: what is merged in may well be set again
        written = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode) and key.value != "<<"]
        twice = sorted({key for key in written if written.count(key) > 1})
        if twice:
            what = f"{', '.join(twice)} stands twice"
            raise yaml.constructor.ConstructorError(None, None, what, node.start_mark)
        return super().construct_mapping(node, deep)


def load_yaml(text: str) -> Any:
    """The content of a YAML text: plain values, nothing run.

    Raises:
        yaml.YAMLError: It is not YAML, or a key stands twice in one mapping.
    """
    return yaml.load(text, _StrictLoader)  # noqa: S506 (a SafeLoader)
