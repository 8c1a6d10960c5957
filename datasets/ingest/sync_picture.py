"""The sync report as a picture: where each stream has data, where it pauses, how far it lies from the ticks."""

from dataclasses import replace
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from navtool.base.pages.svg import Axes, bar, polyline, svg_file, text
from navtool.datasets.store.data_file import Column
from navtool.datasets.streams.table import in_rows
from navtool.pipeline.arrays import Array

_WIDTH, _LEFT, _RIGHT = 1000, 150, 190
_TOP, _LANE = 46, 44
_BINS = 400
_SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)


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
    caption = f"{report['ticks']} ticks at {fps} Hz; the grid follows {report['grid_stream']}"
    legend = "blue: served; red: not valid; line: largest distance from the tick, full height is its tolerance"
    parts = [text(_LEFT, 18, caption), text(_LEFT, 34, legend, "dim")]
    for number, (name, stream) in enumerate(streams.items()):
        parts += _lane(name, stream, columns, _axes(_TOP + number * _LANE, seconds))
    parts += _axes(0, seconds).x_ticks([f"{seconds * share:.1f} s" for share in _SHARES], height - 12)
    return svg_file(_WIDTH, height, f"Sync of {report['ticks']} ticks over {seconds:.1f} s", parts)


def _axes(top: int, seconds: float) -> Axes:
    return Axes(left=_LEFT, top=top, width=_WIDTH - _LEFT - _RIGHT, height=_LANE - 14, x_end=seconds)


def _lane(name: str, stream: dict[str, Any], columns: dict[str, Column], lane: Axes) -> list[str]:
    rate = "" if stream["rate_hz"] is None else f"{stream['rate_hz']:.1f} Hz, "
    served = "" if stream["ticks_served"] is None else f"{stream['ticks_served']} ticks served"
    first, second, right = lane.top + 13, lane.top + 27, _WIDTH - _RIGHT + 8
    parts = [
        text(8, first, name),
        text(8, second, f"{stream['clock']} time", "dim"),
        text(right, first, f"{rate}{stream['messages']} messages", "dim"),
        text(right, second, served, "dim"),
        lane.frame(),
    ]
    column = in_rows(name)
    valid = columns.get(f"valid.{column}")
    if valid is not None:
        errors = np.abs(columns[f"sync.error_s.{column}"]) / stream["tolerance_s"]
        parts += _runs(valid, lane, "bar") + _runs(~valid, lane, "lost")
        parts.append(_line(np.where(valid, errors, 0.0), lane))
    for step in stream["clock_steps"]:
        x = lane.x(min(max(step["at_s"], 0.0), lane.x_end))
        foot = lane.top + lane.height
        parts.append(polyline("step", [x, x], [lane.top, foot], f"clock step {step['by_s']:+g} s"))
    return parts


def _runs(flags: Bool[Array, " ticks"], lane: Axes, kind: str) -> list[str]:
    """A bar for every run of ticks; what is narrower than a pixel is drawn a pixel wide."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))).reshape(-1, 2)
    scale = lane.width / flags.size
    drawn: dict[int, float] = {}
    for first, end in (edges * scale).tolist():
        drawn[int(first)] = max(drawn.get(int(first), 0.0), end, first + 1)
    top = lane.top + lane.height - 6
    return [bar(kind, lane.left + first, top, end - first, 6) for first, end in drawn.items()]


def _line(errors: Float[Array, " ticks"], lane: Axes) -> str:
    """The largest error of each bin, from above the bars up."""
    bins = min(_BINS, errors.size)
    at = np.arange(errors.size) * bins // errors.size
    largest = np.zeros(bins)
    np.maximum.at(largest, at, errors)
    above_bars = replace(lane, height=lane.height - 8, x_end=bins)
    return above_bars.line("trace", np.arange(bins) + 0.5, np.minimum(largest, 1.0))
