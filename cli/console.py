"""Where commands print: results on standard output, everything else on standard error."""

import json
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from navtool.base.note import Note


def console(*, error: bool = False) -> "Console":
    """A console that colours only where a person looks at it; elsewhere tables are up to 200 characters wide."""
    from rich.console import Console

    seen = (sys.stderr if error else sys.stdout).isatty()
    return Console(stderr=error, soft_wrap=True, highlight=False, width=None if seen else 200)


def print_json(content: object) -> None:
    """One JSON document on standard output."""
    sys.stdout.write(json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n")


def print_error(message: str) -> None:
    """A message about a failure on standard error."""
    console(error=True).print("error:", style="bold red", end=" ")
    console(error=True).print(message, markup=False)


def print_table(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """A table on standard output; columns of numbers to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table
    from rich.text import Text

    rows = [tuple(row) for row in rows]
    table = Table(title=title, title_justify="left", title_style="bold", box=SIMPLE_HEAD, pad_edge=False)
    for index, column in enumerate(columns):
        numeric = all(isinstance(row[index], int | float | None) for row in rows)
        table.add_column(column, justify="right" if numeric else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(shown(value)) for value in row))
    console().print(table, soft_wrap=False)


def shown(value: object) -> str:
    """A value as a cell: a dash for None, three significant decimals for a float."""
    if value is None:
        return "-"
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def print_notes(notes: "Iterable[Note | str]") -> None:
    """What the user should look at, a line each, on standard error."""
    for note in notes:
        console(error=True).print(f"note: {note}", style="yellow", markup=False)
