"""The parts that the pages of all methods have."""

from collections.abc import Iterable, Mapping, Sequence
from html import escape

import yaml

from navtool.base.note import Note
from navtool.base.pages.html import html_figure, html_page, html_table
from navtool.base.plain import plain
from navtool.methods.along.pictures import Moment
from navtool.methods.along.report import TableReport

_GRID = "display:grid;grid-template-columns:repeat(auto-fill,minmax(420px,1fr));gap:1rem"


def note_parts(notes: Iterable[Note]) -> list[str]:
    """What a user should look at."""
    return [f'<p class="bad">{escape(note.text)}</p>' for note in notes]


def video_part(name: str, width_px: int) -> str:
    """A video that lies beside the page."""
    return f'<h2>Along the run</h2><video src="{name}" controls width="{width_px}" style="max-width:100%"></video>'


def moment_parts(moments: Sequence[Moment]) -> list[str]:
    """Pictures from all over the recording."""
    figures = (html_figure(moment.png, "png", f"{moment.seconds:.1f} s") for moment in moments)
    return ["<h2>Moments</h2>", f'<div style="{_GRID}">{"".join(figures)}</div>']


def table_parts(title: str, columns: Sequence[str], rows: Iterable[Sequence[object]]) -> list[str]:
    """A table under a heading."""
    return [f"<h2>{escape(title)}</h2>", html_table(columns, rows)]


def settings_parts(config: object) -> list[str]:
    """Every setting, folded away."""
    settings = yaml.safe_dump(plain(config), sort_keys=False, width=100)
    return ["<h2>Settings</h2>", f"<details><summary>all of them</summary><pre>{escape(settings)}</pre></details>"]


def table_page(title: str, report: TableReport, settings: Mapping[str, object]) -> str:
    """The page of a method whose results are lines of a table; texts out of the recording are escaped."""
    facts = f"{report.results} results of {report.ticks} ticks in {report.duration_s:.1f} s"
    parts = [f"<p>{escape(facts)}</p>", *note_parts(report.notes)]
    parts += table_parts("Figures", ("figure", "value"), report.figures.items())
    parts += table_parts("What was left out", ("ticks", "count"), report.skipped.items())
    parts += table_parts("Files", ("output", "results"), report.files.items())
    return html_page(f"{title} of {report.source}", [*parts, *settings_parts(settings)])
