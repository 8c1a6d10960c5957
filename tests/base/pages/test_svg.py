"""Drawings as SVG."""

from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.base.pages.svg import Axes, bar, dot, polyline, svg_file, svg_inside, text

_NS = "{http://www.w3.org/2000/svg}"
_AXES = Axes(left=50, top=20, width=400, height=100, x_end=8.0, y_end=2.0)
_side = st.floats(0.0, 1.0)


def _parsed(*parts: str, title: str = "a drawing") -> ElementTree.Element:
    return ElementTree.fromstring(svg_file(500, 150, title, parts))  # noqa: S314


@given(st.text(st.sampled_from("<>&\"' a\u00e4"), max_size=12))
def test_any_text_comes_back_as_it_was_given(content: str) -> None:
    root = _parsed(text(1, 2, content), polyline("step", [0, 1], [0, 1], content or "none"), title=content)
    titles = [element.text or "" for element in root.iter(f"{_NS}title")]
    assert [element.text or "" for element in root.iter(f"{_NS}text")] == [content]
    assert titles == [content, content or "none"]


@given(_side, _side)
def test_values_within_the_range_lie_on_the_axes_and_lines_go_through_them(across: float, up: float) -> None:
    x, y = _AXES.x(8.0 * across), _AXES.y(2.0 * up)
    assert x == pytest.approx(50 + 400 * across)
    assert y == pytest.approx(120 - 100 * up)
    (line,) = _parsed(_AXES.line("path", [0.0, 8.0 * across], [0.0, 2.0 * up])).iter(f"{_NS}polyline")
    start, end = (np.array(pair.split(","), float) for pair in line.attrib["points"].split())
    np.testing.assert_allclose(start, [50, 120])
    np.testing.assert_allclose(end, [x, y], atol=0.051)


def test_ticks_reach_from_one_end_to_the_other() -> None:
    across = list(_parsed(*_AXES.x_ticks(["a", "b", "c"], 140)))[2:]
    assert [float(tick.attrib["x"]) for tick in across] == [50, 250, 450]
    assert {tick.attrib["y"] for tick in across} == {"140"}
    up = list(_parsed(*_AXES.y_ticks(["a", "b", "c"])))[2:]
    assert [float(tick.attrib["y"]) for tick in up] == [124, 74, 24]


def test_ticks_inside_do_not_stick_out() -> None:
    ticks = list(_parsed(*_AXES.x_ticks(["a", "b", "c"], 140, inside=True)))[2:]
    assert [tick.get("text-anchor", "start") for tick in ticks] == ["start", "middle", "end"]


def test_a_frame_and_a_dot_lie_where_they_are_put() -> None:
    frame, mark = list(_parsed(_AXES.frame(), dot("bar", 3.25, 4)))[2:]
    assert {name: frame.attrib[name] for name in ("x", "y", "width", "height")} == {
        "x": "50",
        "y": "20",
        "width": "400",
        "height": "100",
    }
    assert (mark.attrib["cx"], mark.attrib["cy"]) == ("3.2", "4")


def test_a_drawing_inside_a_page_leaves_the_style_to_the_page() -> None:
    inside = svg_inside(10, 20, [bar("bar", 0, 0, 1, 1, 0.25)], "max-width:10px")
    assert "<style>" not in inside
    drawing = ElementTree.fromstring(inside)  # noqa: S314
    assert (drawing.attrib["viewBox"], drawing.attrib["style"]) == ("0 0 10 20", "max-width:10px")
    assert drawing[0].attrib["opacity"] == "0.25"


def test_as_many_x_as_y_are_asked_for() -> None:
    with pytest.raises(ValueError, match="shorter"):
        polyline("path", [0, 1, 2], [0, 1])
