"""What the commands that make data sets of data sets print."""

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

_EPISODES = re.compile(r"([0-9]{1,9})(?:-([0-9]{1,9}))?")

if TYPE_CHECKING:
    from navtool.datasets.edit.new_data_set import EditReport


def print_edits(reports: Sequence["EditReport"], *, as_json: bool) -> None:
    """The data sets that were made: JSON for programs, a line each for a person."""
    from navtool.base.plain import plain_fields
    from navtool.cli.console import console, print_json

    if as_json:
        print_json({"datasets": [plain_fields(report) for report in reports]})
        return
    for report in reports:
        console().print(f"{report.rows} rows in {report.episodes} episodes; data set: {report.dataset}", markup=False)


def episode_numbers(text: str, episodes: int) -> list[int]:
    """Episodes as a person lists them: ``0,3-5``.

    Args:
        text: The list.
        episodes: How many the data set has; of a range that goes beyond them only the end is listed of the rest.

    Raises:
        UsageError: It is no such list.
    """
    from navtool.cli.compose import UsageError

    numbers: list[int] = []
    for part in text.split(","):
        match = _EPISODES.fullmatch(part.strip())
        first, last = (int(match[1]), int(match[2] or match[1])) if match else (1, 0)
        if last < first:
            raise UsageError(f"{text!r} is no list of episodes", cure="list them as 0,3-5")
        numbers.extend([*range(first, min(last, episodes)), last])
    return numbers
