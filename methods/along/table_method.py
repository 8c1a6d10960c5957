"""Methods whose results are lines of a table: CSV, page and report come with them."""

from abc import abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import ClassVar, NamedTuple, override

from navtool.base.files import write_bytes
from navtool.base.note import Note
from navtool.methods.along.csv_file import CsvFile
from navtool.methods.along.method import Method, Walked
from navtool.methods.along.page import table_page
from navtool.methods.along.report import TableReport
from navtool.methods.along.streams import Streams
from navtool.methods.along.writers import Outcome, Writer


class TableMethod[T, R: NamedTuple](Method[T, R, TableReport]):
    """A method whose result is a NamedTuple of numbers, each a column.

    It writes ``results.csv``, with the stamp of each tick, and ``index.html``.
    """

    title: ClassVar[str]
    """Title of the page."""
    columns: ClassVar[tuple[str, ...]]
    """Names of a result's numbers, with their units."""
    report_type = TableReport

    @abstractmethod
    def figures(self) -> dict[str, float]:
        """What all results came to, by name and unit."""

    def notes(self) -> list[Note]:
        """What a user should look at in the results."""
        return []

    @override
    def writers(self, folder: Path, streams: Streams) -> Sequence[Writer[R]]:
        """The table."""
        return [CsvFile(folder / "results.csv", ("stamp_ns", *self.columns), _line)]

    def report(self, walked: Walked) -> TableReport:
        """Counts, figures and notes."""
        return TableReport(
            out=walked.out,
            source=", ".join(walked.names),
            ticks=walked.ticks,
            results=walked.results,
            duration_s=walked.duration_s,
            figures=self.figures(),
            skipped=dict(walked.unread + walked.skipped),
            files=walked.written,
            notes=[*walked.notes, *self.notes(), *walked.skip_notes],
        )

    def finish(self, folder: Path, report: TableReport) -> None:
        """Write the page."""
        write_bytes(folder / "index.html", table_page(self.title, report, self.settings).encode())


def _line[R: NamedTuple](outcome: Outcome[R]) -> Sequence[object]:
    return (outcome.stamp_ns, *outcome.result)
