"""Settings that a command wrote for another one, as overrides."""

from collections.abc import Iterator, Mapping
from pathlib import Path

import yaml

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
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise UsageError(f"cannot be read ({error.strerror})", where=path, cure=cure) from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise UsageError("is not YAML", where=path, cure=cure) from error
    if not isinstance(content, Mapping) or not content:
        raise UsageError("holds no settings", where=path, cure=cure)
    return list(_flat(content, "", path))


def _flat(content: Mapping[object, object], above: str, path: Path) -> Iterator[str]:
    for key, value in content.items():
        name = f"{above}{key}"
        if isinstance(value, Mapping):
            yield from _flat(value, f"{name}.", path)
        elif isinstance(value, bool | int | float):
            yield f"{name}={str(value).lower() if isinstance(value, bool) else value}"
        elif isinstance(value, str):
            yield f"{name}={quoted(value)}"
        else:
            raise UsageError(f"{name} is {repr(value)[:60]}, wanted a number or a text", where=path, cure="correct it")
