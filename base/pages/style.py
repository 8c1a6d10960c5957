"""The one look of pages and pictures: colours by day and by night, and the colour of each class of obstacle."""

import re

CLASS_COLOURS: dict[str, tuple[int, int, int]] = {
    "pliable": (90, 200, 80),
    "solid": (240, 70, 60),
    "transparent": (60, 190, 255),
}
"""Red, green, blue of what stands around a robot, in every picture and page that shows it."""

_DAY = {
    "ink": "#1f2328",
    "dim": "#656d76",
    "ground": "#fff",
    "lane": "#eef1f4",
    "line": "#d0d7de",
    "bar": "#2f81b7",
    "bad": "#c9354b",
    "trace": "#b8860b",
}
_NIGHT = {
    "ink": "#e6edf3",
    "dim": "#9198a1",
    "ground": "#0d1117",
    "lane": "#1c222b",
    "line": "#30363d",
    "bar": "#58a6ff",
    "bad": "#ff7b72",
    "trace": "#d9a520",
}
_SVG_RULES = """
svg text{font:11px system-ui,sans-serif;fill:var(--ink)}svg .dim{fill:var(--dim)}svg .lane{fill:var(--lane)}
svg .bar{fill:var(--bar)}svg .path{fill:none;stroke:var(--bar);stroke-width:2}svg .scale{stroke:var(--ink)}
svg .lost{fill:var(--bad)}svg .step{stroke:var(--bad);stroke-width:2}svg .trace{fill:none;stroke:var(--trace)}
svg .faint{fill:none;stroke:var(--dim);stroke-width:1.5;stroke-opacity:.5}
svg .dashed{stroke-dasharray:4}
"""


def page_style() -> str:
    """The style sheet of what a page and the pictures inside it share: variables, and the rules of SVG."""
    return f":root{{{_variables(_DAY)}}}{_at_night(f':root{{{_variables(_NIGHT)}}}')}{_SVG_RULES}"


def picture_style() -> str:
    """The style sheet of an SVG file: without variables, which programs other than browsers do not know."""
    return _filled(_DAY) + _at_night(_filled(_NIGHT))


def _variables(colours: dict[str, str]) -> str:
    return ";".join(f"--{name}:{colour}" for name, colour in colours.items())


def _at_night(rules: str) -> str:
    return f"@media(prefers-color-scheme:dark){{{rules}}}"


def _filled(colours: dict[str, str]) -> str:
    return re.sub(r"var\(--(\w+)\)", lambda found: colours[found[1]], _SVG_RULES).replace("\n", "")
