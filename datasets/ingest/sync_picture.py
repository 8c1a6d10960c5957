"""The sync report as a picture: where each stream has data, where it pauses, how far it lies from the ticks."""

from html import escape
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from navtool.datasets.store.data_file import Column
from navtool.datasets.streams.table import STREAMS
from navtool.pipeline.arrays import Array

_WIDTH, _LEFT, _RIGHT = 1000, 150, 190
_TOP, _LANE = 46, 44
_BINS = 400
_STYLE = (
    "text{font:12px sans-serif;fill:#24292f}.dim{fill:#6e7781}.bar{fill:#2f81b7}.lost{fill:#d1495b}"
    ".lane{fill:#eef1f4}.line{stroke:#b8860b;stroke-width:1;fill:none}.step{stroke:#d1495b;stroke-width:2}"
    "@media(prefers-color-scheme:dark){text{fill:#e6edf3}.dim{fill:#9198a1}.lane{fill:#262c36}}"
)


def sync_picture(report: dict[str, Any], columns: dict[str, Column], fps: int) -> str:
    """An SVG of one lane a stream: served ticks, ticks without it, steps of its clock, and its distance from the ticks.

    Args:
        report: The content of ``sync.json``.
        columns: The episode's columns.
        fps: Rate of the grid in Hz.
    """
    streams: dict[str, dict[str, Any]] = report["streams"]
    height = _TOP + _LANE * len(streams) + 34
    seconds = max(report["ticks"] / fps, 1 / fps)
    caption = f"{report['ticks']} ticks at {fps} Hz; the grid follows {escape(str(report['grid_stream']))}"
    legend = "blue: served; red: not valid; line: largest distance from the tick, full height is its tolerance"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {height}" role="img">',
        f"<title>Sync of {report['ticks']} ticks over {seconds:.1f} s</title><style>{_STYLE}</style>",
        f'<text x="{_LEFT}" y="18">{caption}</text>',
        f'<text class="dim" x="{_LEFT}" y="34">{legend}</text>',
    ]
    for number, (name, stream) in enumerate(streams.items()):
        parts += _lane(name, stream, columns, _TOP + number * _LANE, seconds)
    parts += _axis(seconds, height - 12)
    return "\n".join([*parts, "</svg>\n"])


def _lane(name: str, stream: dict[str, Any], columns: dict[str, Column], top: int, seconds: float) -> list[str]:
    wide, tall = _WIDTH - _LEFT - _RIGHT, _LANE - 14
    rate = "" if stream["rate_hz"] is None else f"{stream['rate_hz']:.1f} Hz, "
    served = "" if stream["ticks_served"] is None else f"{stream['ticks_served']} ticks served"
    parts = [
        f'<text x="8" y="{top + 13}">{escape(name)}</text>',
        f'<text class="dim" x="8" y="{top + 27}">{escape(str(stream["clock"]))} time</text>',
        f'<text class="dim" x="{_WIDTH - _RIGHT + 8}" y="{top + 13}">{rate}{stream["messages"]} messages</text>',
        f'<text class="dim" x="{_WIDTH - _RIGHT + 8}" y="{top + 27}">{served}</text>',
        f'<rect class="lane" x="{_LEFT}" y="{top}" width="{wide}" height="{tall}"/>',
    ]
    column = STREAMS[name].in_rows
    valid = columns.get(f"valid.{column}")
    if valid is not None:
        errors = np.abs(columns[f"sync.error_s.{column}"]) / stream["tolerance_s"]
        parts += _runs(valid, top, wide, tall, "bar") + _runs(~valid, top, wide, tall, "lost")
        parts.append(_line(np.where(valid, errors, 0.0), top, wide, tall))
    for step in stream["clock_steps"]:
        x = _LEFT + wide * min(max(step["at_s"] / seconds, 0.0), 1.0)
        parts.append(
            f'<path class="step" d="M{x:.1f} {top}v{tall}"><title>clock step {step["by_s"]:+g} s</title></path>'
        )
    return parts


def _runs(flags: Bool[Array, " ticks"], top: int, wide: int, tall: int, kind: str) -> list[str]:
    """A bar for every run of ticks; what is narrower than a pixel is drawn a pixel wide."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))).reshape(-1, 2)
    scale = wide / flags.size
    drawn: dict[int, float] = {}
    for first, end in (edges * scale).tolist():
        drawn[int(first)] = max(drawn.get(int(first), 0.0), end, first + 1)
    return [
        f'<rect class="{kind}" x="{_LEFT + first}" y="{top + tall - 6}" width="{end - first:.1f}" height="6"/>'
        for first, end in drawn.items()
    ]


def _line(errors: Float[Array, " ticks"], top: int, wide: int, tall: int) -> str:
    """The largest error of each bin, from the lane's foot up."""
    bins = min(_BINS, errors.size)
    at = np.arange(errors.size) * bins // errors.size
    largest = np.zeros(bins)
    np.maximum.at(largest, at, errors)
    height = tall - 8
    points = " ".join(
        f"{_LEFT + (n + 0.5) * wide / bins:.1f},{top + height * (1 - min(value, 1.0)):.1f}"
        for n, value in enumerate(largest.tolist())
    )
    return f'<polyline class="line" points="{points}"/>'


def _axis(seconds: float, bottom: int) -> list[str]:
    wide = _WIDTH - _LEFT - _RIGHT
    where = ((_LEFT + wide * share, seconds * share) for share in (0.0, 0.25, 0.5, 0.75, 1.0))
    style = f'class="dim" y="{bottom}" text-anchor="middle"'
    return [f'<text {style} x="{x:.1f}">{moment:.1f} s</text>' for x, moment in where]
