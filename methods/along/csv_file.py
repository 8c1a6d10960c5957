"""One line a result, as CSV."""

from collections.abc import Callable, Sequence
from io import StringIO
from pathlib import Path

from navtool.base.files import write_bytes
from navtool.methods.along.writers import Outcome, Writer


class CsvFile[R](Writer[R]):
    """Gathers a line a result and writes them at the end; None is left empty."""

    def __init__(self, path: Path, columns: Sequence[str], row: Callable[[Outcome[R]], Sequence[object]]) -> None:
        """Begin it.

        Args:
            path: Of the file.
            columns: The head.
            row: What stands in the line of a result.
        """
        super().__init__("lines")
        self._path, self._row = path, row
        self._text = StringIO()
        self._add(columns)

    def write(self, outcome: Outcome[R]) -> None:
        """Add a result's line."""
        self._add(self._row(outcome))

    def finish(self) -> None:
        """Write the file."""
        write_bytes(self._path, self._text.getvalue().encode())

    def _add(self, cells: Sequence[object]) -> None:
        self._text.write(",".join("" if cell is None else str(cell) for cell in cells) + "\n")
