"""The demo's page: what was recorded, what became of it, and what the model makes of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from navtool.datasets.labels.report import LabelReport
    from navtool.export.verify import VerifyReport
    from navtool.train.evaluate import EvaluationReport

_HONEST = (
    "The demo trains for a few minutes on a few minutes of driving: its figures show that the chain works, and say "
    "nothing about the method."
)


@dataclass(frozen=True, slots=True, kw_only=True)
class DemoReport:
    """What the stages left."""

    stages: Sequence[tuple[str, str, float, Path]]
    """Name, what it does, seconds, output."""
    sheets: Mapping[str, bytes]
    """A contact sheet (PNG) for some recordings, by their names."""
    sync: Mapping[str, str]
    """The sync picture (SVG) for some episodes, by their recordings' names."""
    labels: "LabelReport"
    predictions: bytes
    """Predictions on places that training never saw (PNG)."""
    evaluation: "EvaluationReport"
    verification: "VerifyReport"

    def page(self) -> str:
        """One HTML page with everything inside."""
        from navtool.base.pages.html import html_figure, html_page, html_table

        total_s = sum(seconds for _, _, seconds, _ in self.stages)
        stages = [(name, does, f"{seconds:.1f} s", str(where)) for name, does, seconds, where in self.stages]
        rows = [("failed", self.labels.failed_rows), *sorted(self.labels.reasons.items())]
        checks = [(check.name, "yes" if check.ok else "NO", check.detail) for check in self.verification.checks]
        evaluation = self.evaluation
        return html_page(
            "navtool demo",
            [
                f"<p>From simulated recordings to a verified artefact in {total_s:.0f} s.</p>",
                f'<p class="dim">{_HONEST}</p>',
                html_table(("stage", "what", "time", "output"), stages),
                "<h2>Recordings</h2>",
                *(html_figure(sheet, "png", name) for name, sheet in self.sheets.items()),
                "<h2>Streams on the grid of the data set</h2>",
                *(f"<figure>{svg}<figcaption>{escape(name)}</figcaption></figure>" for name, svg in self.sync.items()),
                f"<h2>Labels of {self.labels.rows} rows</h2>",
                html_table(("what", "rows"), rows),
                f"<h2>Predictions on the {escape(evaluation.split)} split</h2>",
                html_figure(self.predictions, "png", "the predicted trajectory, and E-hat against E along it"),
                html_table(("metric", *evaluation.table.columns), evaluation.table.rows),
                "<h2>The artefact</h2>",
                html_table(("check", "ok", "detail"), checks),
            ],
        )
