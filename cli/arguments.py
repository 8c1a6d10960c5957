"""Telling paths from overrides on a command line that takes both."""

import re
from collections.abc import Sequence
from pathlib import Path

_OVERRIDE = re.compile(r"^[+~]{0,2}[A-Za-z_][\w./@:-]*=")


def split_overrides(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Paths and ``key=value`` overrides; a file that exists is a path whatever its name."""
    paths = [argument for argument in arguments if Path(argument).exists() or not _OVERRIDE.match(argument)]
    return paths, [argument for argument in arguments if argument not in paths]
