"""The one look of pages and pictures."""

import re

from navtool.base.pages.html import html_page
from navtool.base.pages.style import CLASS_COLOURS, page_style, picture_style
from navtool.pipeline.intensity_map.obstacles import CellClass


def test_every_class_of_obstacle_has_its_own_colour() -> None:
    assert set(CLASS_COLOURS) == {kind.name for kind in CellClass} - {"free"}
    assert len(set(CLASS_COLOURS.values())) == len(CLASS_COLOURS)


def test_what_a_page_uses_is_defined_by_day_and_by_night() -> None:
    style = page_style()
    by_day, by_night = style.split("@media", 1)
    used = set(re.findall(r"var\(--(\w+)\)", html_page("a recording", [])))
    for part in (by_day, by_night.partition("}}")[0]):
        assert used <= set(re.findall(r"--(\w+):#", part))


def test_a_picture_has_the_rules_of_a_page_without_variables() -> None:
    rules = [rule for rule in re.findall(r"(svg [.\w]+){", page_style()) if rule]
    assert rules
    by_day, by_night = picture_style().split("@media", 1)
    assert "var(" not in picture_style()
    assert re.findall(r"(svg [.\w]+){", by_day) == rules == re.findall(r"(svg [.\w]+){", by_night)
