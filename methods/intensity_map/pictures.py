"""Maps drawn for people: x, the robot's front, is up, y is to the left."""

import math
from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
from jaxtyping import Bool, Float32, UInt8

from navtool.base.pages.style import CLASS_COLOURS
from navtool.methods.intensity_map.mapped import MappedSweep
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.layer_points import Layer
from navtool.pipeline.intensity_map.obstacles import CellClass

SIDE_PX = 300
"""Size of a panel."""
_TOP_PX, _GAP_PX = 26, 8
_GROUND, _INK, _DIM = (24, 20, 18), (235, 235, 235), (150, 150, 150)
_FREE = (46, 40, 36)
_COLOURS = {
    CellClass.free: _FREE,
    **{CellClass[name]: (blue, green, red) for name, (red, green, blue) in CLASS_COLOURS.items()},
}
"""In OpenCV's order, blue first."""
_ROBOT, _GOAL = (255, 255, 255), (80, 220, 255)
_FAINTEST = 50
"""Where scales of colours begin: below, they are as dark as the ground."""
_TITLES = (
    *("classes", "upper: (0, h]", "level: z = 0"),
    *("plan: 0 to R and above", "below: z = -epsilon", "lower: [-h, 0)"),
)
_FOOT_PX, _SECONDS_LEFT_PX = 9, 740
_FONT = cv2.FONT_HERSHEY_SIMPLEX


def draw_map(mapped: MappedSweep, seconds: float) -> UInt8[Array, "h w 3"]:
    """Classes, plan and the four layers of a map on one picture, in OpenCV's order of colours; sides are even.

    Args:
        mapped: The map.
        seconds: Since the first map.
    """
    grid, points = mapped.config.grid, mapped.map.layers.points
    upper, below, level, lower = (
        _panel(_shade(mapped.values[layer], points[layer] > 0), _VIRIDIS)
        for layer in (Layer.upper, Layer.below, Layer.level, Layer.lower)
    )
    plan = _panel(_shade(mapped.map.plan, mapped.map.plan > 0), _INFERNO)
    # in the order of _TITLES
    panels = [_panel(mapped.classes, _CLASSES), upper, level, plan, below, lower]
    sheet = _empty_sheet(grid.half_m).copy()
    for place, panel in enumerate(panels):
        top, left = _corner(place)
        _draw_robot(panel, mapped, goal=place in (0, 3))
        sheet[top : top + SIDE_PX, left : left + SIDE_PX] = panel
    _write(sheet, f"{seconds:.1f} s   map {mapped.number}", _SECONDS_LEFT_PX, sheet.shape[0] - _FOOT_PX, _DIM)
    return sheet


def legend_colours() -> dict[str, tuple[int, int, int]]:
    """The colour of each class, red first."""
    return {cell.name: (red, green, blue) for cell, (blue, green, red) in _COLOURS.items()}


def _shade(value: Float32[Array, "n n"], there: Bool[Array, "n n"]) -> UInt8[Array, "n n"]:
    """Values of 0 to 1 as 1 to 255; 0 where there is none."""
    return np.asarray((np.minimum(value, np.float32(1)) * np.float32(254) + np.float32(1)) * there, np.uint8)


def _panel(cells: UInt8[Array, "n n"], colours: UInt8[Array, "256 1 3"]) -> UInt8[Array, "side side 3"]:
    """A grid as a picture: r grows upwards, c to the left."""
    turned = np.ascontiguousarray(cells[::-1, ::-1])
    shown = cv2.resize(turned, (SIDE_PX, SIDE_PX), interpolation=cv2.INTER_NEAREST)
    return np.asarray(cv2.applyColorMap(shown, colours), np.uint8)


def _draw_robot(panel: UInt8[Array, "side side 3"], mapped: MappedSweep, *, goal: bool) -> None:
    """The robot as a ring with its front, and an arrow to the goal."""
    middle, scale = SIDE_PX // 2, SIDE_PX / (2 * mapped.config.grid.half_m)
    radius = max(2, round(mapped.config.robot_radius_m * scale))
    cv2.circle(panel, (middle, middle), radius, _ROBOT, 1, cv2.LINE_AA)
    cv2.line(panel, (middle, middle), (middle, middle - radius), _ROBOT, 1, cv2.LINE_AA)
    if goal:
        away = 0.22 * SIDE_PX
        tip = middle - away * math.sin(mapped.goal_rad), middle - away * math.cos(mapped.goal_rad)
        cv2.arrowedLine(panel, (middle, middle), (round(tip[0]), round(tip[1])), _GOAL, 1, cv2.LINE_AA, 0, 0.15)


def _corner(place: int) -> tuple[int, int]:
    """Top and left of a panel."""
    row, column = divmod(place, 3)
    return _GAP_PX + _TOP_PX + row * (SIDE_PX + _TOP_PX + _GAP_PX), _GAP_PX + column * (SIDE_PX + _GAP_PX)


@cache
def _empty_sheet(half_m: float) -> UInt8[Array, "h w 3"]:
    """A picture without its panels: titles and legend."""
    width, height = 3 * SIDE_PX + 4 * _GAP_PX, 2 * (SIDE_PX + _TOP_PX) + 3 * _GAP_PX + _TOP_PX
    sheet = np.full((height + height % 2, width + width % 2, 3), _GROUND, np.uint8)
    for place, title in enumerate(_TITLES):
        top, left = _corner(place)
        _write(sheet, title, left, top - 9)
    base, left = sheet.shape[0] - _FOOT_PX, _GAP_PX
    for cell, colour in _COLOURS.items():
        cv2.rectangle(sheet, (left, base - 10), (left + 10, base), colour, cv2.FILLED)
        cv2.rectangle(sheet, (left, base - 10), (left + 10, base), _DIM, 1)
        left = _write(sheet, cell.name, left + 16, base) + 14
    left = _write(sheet, "ring: robot, front up", left, base, _DIM) + 14
    left = _write(sheet, "arrow: goal", left, base, _GOAL) + 14
    _write(sheet, f"{2 * half_m:g} m wide", left, base, _DIM)
    return sheet


def _write(sheet: UInt8[Array, "h w 3"], text: str, left: int, base: int, colour: Sequence[int] = _INK) -> int:
    """Write a text, and say where it ends."""
    cv2.putText(sheet, text, (left, base), _FONT, 0.42, colour, 1, cv2.LINE_AA)
    return left + int(cv2.getTextSize(text, _FONT, 0.42, 1)[0][0])


def _colours_of(scale: int) -> UInt8[Array, "256 1 3"]:
    """A scale of colours whose first one is that of free cells."""
    shades = np.linspace(_FAINTEST, 255, 256).astype(np.uint8).reshape(256, 1)
    colours = np.asarray(cv2.applyColorMap(shades, scale), np.uint8)
    colours[0, 0] = _FREE
    return colours


def _colours_of_classes() -> UInt8[Array, "256 1 3"]:
    colours = np.zeros((256, 1, 3), np.uint8)
    for cell, colour in _COLOURS.items():
        colours[cell, 0] = colour
    return colours


_VIRIDIS, _INFERNO, _CLASSES = (
    _colours_of(cv2.COLORMAP_VIRIDIS),
    _colours_of(cv2.COLORMAP_INFERNO),
    _colours_of_classes(),
)
