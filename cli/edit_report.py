"""What the commands that make data sets of data sets print."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

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


def episode_numbers(text: str) -> list[int]:
    """Episodes as a person lists them: ``0,3-5``.

    Raises:
        UsageError: It is no such list.
    """
    from navtool.cli.compose import UsageError

    numbers: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        if not first.isdecimal() or (dash and not last.isdecimal()) or (dash and int(last) < int(first)):
            raise UsageError(f"{text!r} is no list of episodes", cure="list them as 0,3-5")
        numbers.extend(range(int(first), int(last if dash else first) + 1))
    return numbers
