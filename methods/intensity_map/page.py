"""The page of a run's maps: pictures, figures, settings, what was left out."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

import yaml

from navtool.base.files import write_bytes
from navtool.base.pages.html import html_figure, html_page, html_table
from navtool.base.plain import plain
from navtool.methods.intensity_map.config import MapRunConfig
from navtool.methods.intensity_map.outputs import VIDEO, Moment
from navtool.methods.intensity_map.pictures import legend_colours
from navtool.methods.intensity_map.report import MapReport

_GRID = "display:grid;grid-template-columns:repeat(auto-fill,minmax(420px,1fr));gap:1rem"
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
    parts = [f"<p>{escape(facts)}; <code>{escape(report.topic)}</code></p>"]
    parts += [f'<p class="bad">{escape(note)}</p>' for note in report.notes]
    if report.files.get("video"):
        parts.append(f'<h2>Along the run</h2><video src="{VIDEO}" controls width="944" style="max-width:100%"></video>')
    parts += ["<h2>What the colours mean</h2>", _legend(report)]
    parts += ["<h2>Moments</h2>", _figures(moments)]
    if report.scores:
        columns = ("cells", "precision", "recall", "F")
        scored = ((name, score.precision, score.recall, score.f) for name, score in report.scores.items())
        parts += ["<h2>Agreement with what stands there</h2>", html_table(columns, scored)]
    left_out = [(f"clouds: {reason}", count) for reason, count in report.skipped.items()]
    left_out += [(f"points: {reason}", count) for reason, count in report.points_dropped.items()]
    left_out += [("maps that stand alone, without odometry", report.without_odometry)]
    left_out += [("maps not scored: the robot's place is not known", report.not_scored)]
    left_out += [("jumps of the odometry", report.odometry_jumps)]
    parts += ["<h2>What was left out</h2>", html_table(("what", "count"), left_out)]
    parts += ["<h2>Files</h2>", html_table(("output", "maps"), report.files.items())]
    settings = yaml.safe_dump(plain(config), sort_keys=False, width=100)
    parts += ["<h2>Settings</h2>", f"<details><summary>all of them</summary><pre>{escape(settings)}</pre></details>"]
    return html_page(f"Intensity maps of {report.source}", parts)


def _figures(moments: Sequence[Moment]) -> str:
    figures = (html_figure(moment.png, "png", f"{moment.seconds:.1f} s") for moment in moments)
    return f'<div style="{_GRID}">{"".join(figures)}</div>'


def _legend(report: MapReport) -> str:
    rows = []
    for name, (red, green, blue) in legend_colours().items():
        patch = f'<span style="display:inline-block;width:1em;height:1em;background:rgb({red},{green},{blue})"></span>'
        cells = report.cells[name] / max(report.maps, 1)
        shown = f'<td class="n">{report.maps_with[name]}</td><td class="n">{cells:.0f}</td>'
        rows.append(f"<tr><td>{patch} {name}</td><td>{_MEANING[name]}</td>{shown}</tr>")
    head = '<tr><th>class</th><th>meaning</th><th class="n">maps with it</th><th class="n">cells a map</th></tr>'
    return f'<div class="wide"><table><thead>{head}</thead><tbody>{"".join(rows)}</tbody></table></div>'
