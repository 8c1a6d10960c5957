"""The page of a recording."""

from html import escape
from itertools import pairwise
from pathlib import Path

import numpy as np
from jaxtyping import Float64, Int64

from navtool.base.pages.html import html_figure, html_page
from navtool.base.pages.svg import Axes, bar, dot, polyline, svg_inside, text
from navtool.datasets.inspect.inspection import Inspection, TopicReport
from navtool.datasets.inspect.samples import Cloud, Samples
from navtool.datasets.streams.table import sensor_of
from navtool.pipeline.arrays import Array


def recording_page(inspection: Inspection, samples: Samples) -> str:
    """The recording as HTML; texts out of the recording are escaped, and the same recording gives the same page."""
    name = Path(inspection.path).name
    seconds = (inspection.end_ns - inspection.start_ns) * 1e-9
    facts = (
        f"{inspection.format}, {seconds:.1f} s, {inspection.messages} messages on "
        f"{sum(topic.count > 0 for topic in inspection.topics)} topics"
    )
    parts = [
        f"<p>{escape(facts)}</p>",
        *(f'<p class="bad">{escape(fault)}</p>' for fault in (*inspection.faults, *dict.fromkeys(samples.faults))),
        "<h2>Streams</h2>",
        _streams(inspection),
        "<h2>When the topics speak</h2>",
        _timeline(samples.density, seconds),
        "<h2>Topics</h2>",
        _topics(inspection),
    ]
    for stream in dict.fromkeys(frame.stream for frame in samples.frames):
        shown = [frame for frame in samples.frames if frame.stream == stream]
        figures = (html_figure(frame.jpeg, "jpeg", f"{frame.at_s:.1f} s") for frame in shown)
        title = f"Camera {sensor_of(stream)}" if sensor_of(stream) else "Front camera"
        parts += [f"<h2>{title}</h2>", f'<div class="row">{"".join(figures)}</div>']
    for stream, cloud in samples.clouds.items():
        parts += [f"<h2>{f'LiDAR {sensor_of(stream)}'.rstrip()}</h2>", _cloud(cloud)]
    if len(samples.path) > 1:
        parts += ["<h2>Path driven</h2>", _path(samples.path), "<h2>Speed along it</h2>", _speed(samples.path)]
    return html_page(name, parts)


def _streams(inspection: Inspection) -> str:
    rows = [
        f"<tr><td>{stream}</td><td><code>{escape(topic)}</code></td></tr>"
        for stream, topic in inspection.topic_map.streams.items()
    ]
    rows += [
        f"<tr><td>(could be {stream})</td><td><code>{escape(topic)}</code></td></tr>"
        for stream, topic in inspection.topic_map.further.items()
    ]
    rows += [f"<tr><td>transforms</td><td><code>{escape(t)}</code></td></tr>" for t in inspection.topic_map.transforms]
    notes = "".join(f'<p class="dim">{escape(note.text)}</p>' for note in inspection.topic_map.notes)
    none = "<p>No topic fits a stream of a data set.</p>"
    return (f"<table><tbody>{''.join(rows)}</tbody></table>" if rows else none) + notes


def _topics(inspection: Inspection) -> str:
    why = {topic.name: topic.reason for topic in inspection.topic_map.not_used}
    head = "".join(
        f'<th class="n">{title}</th>' if numeric else f"<th>{title}</th>"
        for title, numeric in (
            ("topic", False),
            ("type", False),
            ("messages", True),
            ("rate Hz", True),
            ("longest gap s", True),
            ("header - record s", True),
            ("not used because", False),
        )
    )
    rows = "".join(_topic(topic, why.get(topic.name, "")) for topic in inspection.topics)
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table></div>'


def _topic(topic: TopicReport, reason: str) -> str:
    figures = (f"{topic.count}", _number(topic.rate_hz), _number(topic.gap_max_s), _number(topic.clock_offset_s))
    cells = "".join(f'<td class="n">{figure}</td>' for figure in figures)
    said = [reason]
    if topic.backwards:
        said.append(f"{topic.backwards} stamps run backwards")
    if topic.zero_stamps:
        said.append(f"{topic.zero_stamps} empty stamps")
    if topic.unreadable:
        said.append(f"{topic.unreadable} unreadable")
    text = escape("; ".join(part for part in said if part))
    name, kind = escape(topic.name), escape(topic.type)
    return f'<tr><td><code>{name}</code></td><td class="dim">{kind}</td>{cells}<td class="dim">{text}</td></tr>'


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _timeline(density: dict[str, Int64[Array, " bins"]], seconds: float) -> str:
    """A lane a topic: the fuller a portion of time, the darker; empty portions stay empty."""
    left, wide, tall = 300, 760, 20
    height = tall * len(density) + 30
    parts: list[str] = []
    for number, (topic, counts) in enumerate(sorted(density.items())):
        top = number * tall
        shown = topic if len(topic) <= 46 else f"...{topic[-43:]}"
        lane = Axes(left=left, top=top + 2, width=wide, height=tall - 5, x_end=counts.size)
        parts += [text(0, top + 13, shown), lane.frame(), *_fullness(counts, lane)]
    parts += Axes(left=left, top=0, width=wide, height=height).x_ticks(_seconds(seconds), height - 8, inside=True)
    return f'<div class="wide">{svg_inside(left + wide, height, parts, "min-width:640px")}</div>'


def _fullness(counts: Int64[Array, " bins"], lane: Axes) -> list[str]:
    """A bar for every portion of time that is equally full, in quarters of the usual."""
    usual = float(np.median(counts[counts > 0])) if counts.any() else 1.0
    levels = np.minimum(np.ceil(4 * counts / usual) / 4, 1.0)
    edges = np.flatnonzero(np.diff(levels, prepend=-1.0, append=-1.0)).tolist()
    return [
        bar("bar", lane.x(first), lane.top, lane.x(end) - lane.x(first), lane.height, float(levels[first]))
        for first, end in pairwise(edges)
        if levels[first] > 0
    ]


def _cloud(cloud: Cloud) -> str:
    above = html_figure(cloud.above, "png", f"{cloud.points} points at {cloud.at_s:.1f} s from above, x up, 60 m wide")
    side = html_figure(cloud.side, "png", "from the side, x to the right; colour is intensity, or height without it")
    return f'<div class="row">{above}{side}</div>'


def _path(path: Float64[Array, "n 3"]) -> str:
    """X up and y left, as seen from above by the robot at its start; with a scale."""
    across, down = -path[:, 2], -path[:, 1]
    low_x, low_y = float(across.min()), float(down.min())
    extent = max(float(np.ptp(across)), float(np.ptp(down)), 1.0)
    size, margin = 460.0, 30.0
    scale = size / extent
    x, y = margin + (across - low_x) * scale, margin + (down - low_y) * scale
    bar_m = 10.0 ** np.floor(np.log10(extent / 2))
    wide, tall = 2 * margin + float(np.ptp(across)) * scale, 2 * margin + float(np.ptp(down)) * scale + 30
    wide = max(wide, 2 * margin + bar_m * scale + 60)
    length = float(np.linalg.norm(np.diff(path[:, 1:], axis=0), axis=1).sum())
    foot, bar_end = tall - 12, margin + bar_m * scale
    parts = [
        polyline("path", x, y),
        dot("bar", x[0], y[0]),
        text(x[0] + 8, y[0] + 4, "start"),
        text(x[-1] + 8, y[-1] + 4, "end"),
        polyline("scale", [margin, bar_end], [foot, foot]),
        text(bar_end + 6, foot + 4, f"{bar_m:g} m"),
    ]
    drawing = svg_inside(wide, tall, parts, f"max-width:{wide:.0f}px")
    return f'{drawing}<p class="dim">{length:.1f} m by the odometry</p>'


def _speed(path: Float64[Array, "n 3"]) -> str:
    """Metres a second between poses, smoothed over the width of a pixel."""
    wide, tall, bins = 760, 90, 240
    time_s, steps = path[1:, 0], np.linalg.norm(np.diff(path[:, 1:], axis=0), axis=1)
    at = np.minimum(((time_s - path[0, 0]) / max(float(np.ptp(path[:, 0])), 1e-9) * (bins - 1)).astype(int), bins - 1)
    covered, lasted = np.zeros(bins), np.zeros(bins)
    np.add.at(covered, at, steps)
    np.add.at(lasted, at, np.diff(path[:, 0]))
    there = lasted > 0
    speed = covered[there] / lasted[there]
    highest = max(float(speed.max(initial=0.0)), 1e-9)
    axes = Axes(left=0, top=16, width=wide, height=tall - 30, x_end=bins, y_end=highest)
    parts = [axes.line("path", np.flatnonzero(there), speed), text(0, 12, f"{highest:.2f} m/s", "dim")]
    parts += axes.x_ticks(_seconds(float(np.ptp(path[:, 0]))), tall - 2, inside=True)
    return svg_inside(wide, tall, parts)


def _seconds(length: float) -> list[str]:
    """The times from the start at the ends of an axis, and between them."""
    return [f"{share * length:.1f} s" for share in (0.0, 0.25, 0.5, 0.75, 1.0)]
