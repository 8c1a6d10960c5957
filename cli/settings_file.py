"""Settings that a command wrote for another one, as overrides."""

from collections.abc import Mapping
from pathlib import Path

import yaml

from navtool.base.plain import flatten
from navtool.base.yaml_text import load_yaml
from navtool.cli.compose import UsageError, quoted


def settings_overrides(path: Path | None) -> list[str]:
    """A YAML file's settings as ``key=value``; none where no file was named.

    Raises:
        UsageError: It cannot be read, or is not a table of settings.
    """
    if path is None:
        return []
    cure = "name a file such as `navtool fit intensity_threshold` writes"
    try:
        content = load_yaml(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot be read ({error.strerror})", where=path, cure=cure) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UsageError("is not YAML", where=path, cure=cure) from error
    if not isinstance(content, Mapping) or not content:
        raise UsageError("holds no settings", where=path, cure=cure)
    return [f"{key}={_right_hand_side(key, value, path)}" for key, value in flatten(content).items()]


def _right_hand_side(key: str, value: object, path: Path) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return str(value)
    if isinstance(value, str):
        return quoted(value)
    raise UsageError(f"{key} is {repr(value)[:60]}, wanted a number or a text", where=path, cure="correct it")
