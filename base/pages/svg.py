"""Drawings as SVG: elements as text, in pixels from the upper left corner, and axes that place values on them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from navtool.base.pages.style import picture_style

type Anchor = Literal["start", "middle", "end"]


def svg_file(width: float, height: float, title: str, parts: Iterable[str]) -> str:
    """The content of an SVG file that needs nothing else; the title is a text and gets escaped."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_px(width)} {_px(height)}" role="img">'
    about = f"<title>{escape(title)}</title><style>{picture_style()}</style>"
    return "\n".join([head, about, *parts, "</svg>\n"])


def svg_inside(width: float, height: float, parts: Iterable[str], style: str = "") -> str:
    """A drawing inside a page, which brings the style sheet.

    Args:
        width: In pixels, as the height; the page may show it larger or smaller.
        height: In pixels.
        parts: Elements.
        style: Declarations for the drawing as a whole, such as ``max-width:300px``.
    """
    own = f' style="{style}"' if style else ""
    return f'<svg viewBox="0 0 {_px(width)} {_px(height)}" role="img"{own}>{"".join(parts)}</svg>'


def text(x: float, y: float, content: str, kind: str = "", anchor: Anchor = "start", *, upwards: bool = False) -> str:
    """A text, escaped, at its base line.

    Args:
        x: Of its start, or of what `anchor` says.
        y: Of its base line.
        content: The text.
        kind: A class of the style sheet: ``dim``.
        anchor: What of the text stands at `x`.
        upwards: Whether it runs from the bottom to the top.
    """
    marks = (f' class="{kind}"' if kind else "") + ("" if anchor == "start" else f' text-anchor="{anchor}"')
    place = f'transform="translate({_px(x)} {_px(y)})rotate(-90)"' if upwards else f'x="{_px(x)}" y="{_px(y)}"'
    return f"<text{marks} {place}>{escape(content)}</text>"


def bar(kind: str, x: float, y: float, width: float, height: float, opacity: float = 1.0) -> str:
    """A filled rectangle; `kind` is a class of the style sheet: ``bar``, ``lane`` or ``lost``."""
    fainter = "" if opacity == 1 else f' opacity="{opacity:.2f}"'
    return f'<rect class="{kind}" x="{_px(x)}" y="{_px(y)}" width="{_px(width)}" height="{_px(height)}"{fainter}/>'


def dot(kind: str, x: float, y: float) -> str:
    """A filled circle of ten pixels."""
    return f'<circle class="{kind}" cx="{_px(x)}" cy="{_px(y)}" r="5"/>'


def polyline(kind: str, x: ArrayLike, y: ArrayLike, title: str = "") -> str:
    """A line through points.

    Args:
        kind: Classes of the style sheet: ``path``, ``trace``, ``step``, ``scale``, ``faint``, ``dashed``.
        x: Of every point.
        y: As many.
        title: What is shown where a pointer rests on the line.
    """
    pairs = zip(np.asarray(x, np.float64).tolist(), np.asarray(y, np.float64).tolist(), strict=True)
    points = " ".join(f"{_px(across)},{_px(down)}" for across, down in pairs)
    return f'<polyline class="{kind}" points="{points}"' + (
        f"><title>{escape(title)}</title></polyline>" if title else "/>"
    )


@dataclass(frozen=True, kw_only=True, slots=True)
class Axes:
    """A rectangle of a drawing on which values are placed: x from its left edge, y from its foot upwards."""

    left: float
    top: float
    width: float
    height: float
    x_end: float = 1.0
    """Value at the right edge; at the left edge it is 0."""
    y_end: float = 1.0
    """Value at the top; at the foot it is 0."""

    def x(self, value: float) -> float:
        """Where a value lies across the drawing."""
        return self.left + self.width * value / self.x_end

    def y(self, value: float) -> float:
        """Where a value lies down the drawing."""
        return self.top + self.height * (1 - value / self.y_end)

    def frame(self) -> str:
        """The ground on which the values lie."""
        return bar("lane", self.left, self.top, self.width, self.height)

    def line(self, kind: str, x: ArrayLike, y: ArrayLike) -> str:
        """A line through values; see `polyline`."""
        across = self.left + self.width * np.asarray(x, np.float64) / self.x_end
        return polyline(kind, across, self.top + self.height * (1 - np.asarray(y, np.float64) / self.y_end))

    def x_ticks(self, labels: Sequence[str], down: float, *, inside: bool = False) -> list[str]:
        """Labels at equal distances from the left edge to the right one, the first and last at the edges.

        Args:
            labels: Two or more.
            down: Of their base line in the drawing.
            inside: Whether the first and the last stay between the edges.
        """
        ends: dict[int, Anchor] = {0: "start", len(labels) - 1: "end"} if inside else {}
        step = self.width / (len(labels) - 1)
        return [text(self.left + n * step, down, label, "dim", ends.get(n, "middle")) for n, label in enumerate(labels)]

    def y_ticks(self, labels: Sequence[str]) -> list[str]:
        """Labels beside the left edge at equal distances, the first at the foot and the last at the top."""
        step = self.height / (len(labels) - 1)
        foot = self.top + self.height + 4
        return [text(self.left - 8, foot - n * step, label, "dim", "end") for n, label in enumerate(labels)]


def _px(value: float) -> str:
    """A tenth of a pixel is as fine as anything is drawn."""
    return f"{value:.1f}".removesuffix(".0")
