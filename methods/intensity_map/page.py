"""The page of a run's maps: pictures, figures, settings, what was left out."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from navtool.base.files import write_bytes
from navtool.base.pages.html import html_page
from navtool.methods.along.page import moment_parts, note_parts, settings_parts, table_parts, video_part
from navtool.methods.along.pictures import Moment
from navtool.methods.intensity_map.config import MapRunConfig
from navtool.methods.intensity_map.pictures import legend_colours
from navtool.methods.intensity_map.report import MapReport

VIDEO = "map.mp4"
"""Name of the video beside the page."""
_MEANING = {
    "free": "no return: free space, or not seen",
    "pliable": "weak returns: yields to the robot",
    "solid": "strong returns: does not yield",
    "transparent": "glass: found where beams met it at right angles, and remembered",
}


def write_page(path: Path, report: MapReport, config: MapRunConfig, moments: Sequence[Moment]) -> None:
    """Write the page; it has no script, and refers to the video beside it alone. The same run gives the same page."""
    write_bytes(path, map_page(report, config, moments).encode())


def map_page(report: MapReport, config: MapRunConfig, moments: Sequence[Moment]) -> str:
    """The page as HTML; texts out of the recording are escaped."""
    height = f"sensor {report.sensor_height_m:.3g} m above the ground ({report.height_from})"
    facts = f"{report.maps} maps of {report.clouds} clouds in {report.duration_s:.1f} s; {height}; {report.sensor}"
    parts = [f"<p>{escape(facts)}; <code>{escape(report.topic)}</code></p>", *note_parts(report.notes)]
    if report.files.get("video"):
        parts.append(video_part(VIDEO, 944))
    parts += ["<h2>What the colours mean</h2>", _legend(report), *moment_parts(moments)]
    if report.scores:
        scored = ((name, score.precision, score.recall, score.f) for name, score in report.scores.items())
        parts += table_parts("Agreement with what stands there", ("cells", "precision", "recall", "F"), scored)
    parts += table_parts("What was left out", ("what", "count"), _left_out(report))
    parts += table_parts("Files", ("output", "maps"), report.files.items())
    return html_page(f"Intensity maps of {report.source}", [*parts, *settings_parts(config)])


def _left_out(report: MapReport) -> list[tuple[str, int]]:
    left_out = [(f"clouds: {reason}", count) for reason, count in report.skipped.items()]
    left_out += [(f"points: {reason}", count) for reason, count in report.points_dropped.items()]
    return [
        *left_out,
        ("maps that stand alone, without odometry", report.without_odometry),
        ("maps not scored: the robot's place is not known", report.not_scored),
        ("jumps of the odometry", report.odometry_jumps),
    ]


def _legend(report: MapReport) -> str:
    rows = []
    for name, (red, green, blue) in legend_colours().items():
        patch = f'<span style="display:inline-block;width:1em;height:1em;background:rgb({red},{green},{blue})"></span>'
        cells = report.cells[name] / max(report.maps, 1)
        shown = f'<td class="n">{report.maps_with[name]}</td><td class="n">{cells:.0f}</td>'
        rows.append(f"<tr><td>{patch} {name}</td><td>{_MEANING[name]}</td>{shown}</tr>")
    head = '<tr><th>class</th><th>meaning</th><th class="n">maps with it</th><th class="n">cells a map</th></tr>'
    return f'<div class="wide"><table><thead>{head}</thead><tbody>{"".join(rows)}</tbody></table></div>'
