"""Pictures of places, clouds and surfaces from above, for people to look at."""

from collections.abc import Collection, Sequence

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from navtool.base.pages.style import CLASS_COLOURS
from navtool.pipeline.arrays import Array
from navtool.sim.drive.drive import Drive
from navtool.sim.record.truth import obstacle_class, outline
from navtool.sim.sensors.lidar import Cloud
from navtool.sim.sensors.shader import SKY
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import SURFACES

type Colour = tuple[int, int, int]
"""Red, green, blue."""

INK: Colour = (25, 25, 25)
_PATH: Colour = (30, 60, 220)
_FAILED: Colour = (190, 0, 170)
_PALETTE: dict[str, Colour] = {
    "concrete": (178, 178, 178),
    "asphalt": (95, 95, 105),
    "sand": (226, 200, 130),
    "gravel": (158, 145, 130),
    "mulch": (140, 85, 45),
    "rock_bed": (120, 115, 140),
    "grass": (130, 190, 90),
    "mud": (85, 60, 40),
    "bark": (100, 55, 20),
    "twig": (165, 110, 60),
    "leaf": (25, 110, 45),
    "bush_leaf": (60, 150, 130),
    "tall_grass": (200, 215, 50),
    "rock": (130, 90, 170),
    "brick": (200, 75, 50),
    "plaster": (240, 225, 205),
    "steel": (70, 130, 180),
    "glass": (120, 225, 245),
    "bead": (235, 120, 190),
}
_SKY: Colour = (205, 225, 250)
_BORDER_M = 3.0
_DISTANCE_M = 5.0


def surface_colours() -> UInt8[Array, "256 3"]:
    """The colour of each surface's number, and of the sky's."""
    table = np.zeros((256, 3), np.uint8)
    for number, surface in enumerate(SURFACES):
        table[number] = _PALETTE[surface.name]
    table[SKY] = _SKY
    return table


def write(canvas: UInt8[Array, "h w 3"], text: str, x: int, y: int, size: float = 0.42, colour: Colour = INK) -> None:
    """Write onto a canvas, from the left end of the text's base line."""
    cv2.putText(canvas, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, size, colour, 1, cv2.LINE_AA)


def draw_cloud(cloud: Cloud, side_px: int, reach_m: float = 10.0) -> UInt8[Array, "s s 3"]:
    """A cloud from above, ahead is up: blue for an intensity of 0, through green and yellow, to red for 255."""
    canvas = np.full((side_px, side_px, 3), 22, np.uint8)
    middle, scale = side_px / 2, side_px / (2 * reach_m)
    for ring_m in np.arange(_DISTANCE_M, reach_m + 0.1, _DISTANCE_M).tolist():
        cv2.circle(canvas, (int(middle), int(middle)), round(ring_m * scale), (60, 60, 60), 1, cv2.LINE_AA)
    row = np.round(middle - cloud.xyz[:, 0] * scale).astype(np.int64)
    column = np.round(middle - cloud.xyz[:, 1] * scale).astype(np.int64)
    inside = (row >= 0) & (row < side_px) & (column >= 0) & (column < side_px)
    order = np.flatnonzero(inside)[np.argsort(cloud.xyz[inside, 2], kind="stable")]
    canvas[row[order], column[order]] = _intensity_colours()[cloud.intensity[order].astype(np.uint8)]
    corners = middle + np.array([[0.0, -0.5], [0.25, 0.35], [-0.25, 0.35]]) * scale
    cv2.polylines(canvas, [np.round(corners).astype(np.int32)], isClosed=True, color=(255, 255, 255))
    return canvas


def legend(surfaces: Collection[int], width_px: int) -> UInt8[Array, "h w 3"]:
    """What the colours of surfaces, of intensity and of what stands on the map mean."""
    named = {number: surface.name for number, surface in enumerate(SURFACES)} | {SKY: "sky"}
    entries = [(named[number], tuple(surface_colours()[number].tolist())) for number in sorted(surfaces)]
    entries += [(f"map: {name}", colour) for name, colour in CLASS_COLOURS.items()]
    columns = 7
    canvas = np.full((20 * (1 + -(-len(entries) // columns)), width_px, 3), 255, np.uint8)
    for place, (name, colour) in enumerate(entries):
        row, column = divmod(place, columns)
        x, y = column * (width_px // columns), 20 * row + 4
        cv2.rectangle(canvas, (x, y), (x + 12, y + 12), colour, -1)
        cv2.rectangle(canvas, (x, y), (x + 12, y + 12), (120, 120, 120), 1)
        write(canvas, name, x + 18, y + 11)
    canvas[-16:-4, :256] = _intensity_colours()[None]
    write(canvas, "intensity of points, 0 to 255; circles every 5 m", 264, len(canvas) - 5)
    return canvas


def _intensity_colours() -> UInt8[Array, "256 3"]:
    return np.ascontiguousarray(
        cv2.applyColorMap(np.arange(256, dtype=np.uint8)[:, None], cv2.COLORMAP_TURBO)[:, 0, ::-1]
    )


class PlaceMap:
    """A place from above with what stands there; x to the right, y up."""

    def __init__(self, world: World, drive: Drive, width_px: int) -> None:
        """Draw the place.

        Args:
            world: The place.
            drive: What has to be within the map, beside start and goal.
            width_px: Of the map; its height follows.
        """
        known = np.concatenate([drive.position_m[:, :2], [world.start_m, world.goal_m]])
        limit = world.ground.half_side_m
        self._low: Array = np.maximum(known.min(axis=0) - _BORDER_M, -limit)
        high = np.minimum(known.max(axis=0) + _BORDER_M, limit)
        span = high - self._low
        wanted = max(float(span[1]), 0.9 * float(span[0]))
        self._low[1] -= (wanted - span[1]) / 2
        self._scale = width_px / float(span[0])
        self._height = round(wanted * self._scale)
        self.canvas: Array = self._ground(world, width_px)
        self._things(world)

    def pixels(self, points_m: Float[Array, "n 2"]) -> Array:
        """Where points of the world are on the map: columns and rows, 32-bit whole numbers."""
        x, y = ((points_m - self._low) * self._scale).T
        return np.round(np.stack([x, self._height - 1 - y], axis=1)).astype(np.int32)

    def draw_drive(self, drive: Drive, moments_s: Sequence[float]) -> None:
        """Draw the way that was driven, purple where something had gone wrong, with moments by number and failures."""
        every = max(1, round(0.1 / float(drive.time_s[1])))
        way = self.pixels(drive.position_m[::every, :2])
        cv2.polylines(self.canvas, [way], isClosed=False, color=(255, 255, 255), thickness=4, lineType=cv2.LINE_AA)
        cv2.polylines(self.canvas, [way], isClosed=False, color=_PATH, thickness=2, lineType=cv2.LINE_AA)
        time_s = drive.time_s[::every]
        for failure in drive.failures:
            part = way[(time_s >= failure.start_s) & (time_s <= failure.end_s)]
            cv2.polylines(self.canvas, [part], isClosed=False, color=_FAILED, thickness=3, lineType=cv2.LINE_AA)
        for number, (column, row) in enumerate(self.pixels(drive.pose(np.array(moments_s))[:, :2, 3]).tolist(), 1):
            cv2.circle(self.canvas, (column, row), 8, (255, 255, 255), -1, cv2.LINE_AA)
            cv2.circle(self.canvas, (column, row), 8, _PATH, 1, cv2.LINE_AA)
            write(self.canvas, str(number), column - 4, row + 4, 0.4)
        spots: dict[tuple[str, int, int], list[str]] = {}
        for failure in drive.failures:
            column, row = self.pixels(np.array([[failure.x_m, failure.y_m]]))[0].tolist()
            cv2.drawMarker(self.canvas, (column, row), _FAILED, cv2.MARKER_TILTED_CROSS, 14, 2, cv2.LINE_AA)
            near = [
                spot
                for spot in spots
                if spot[0] == failure.kind.value and np.hypot(column - spot[1], row - spot[2]) < 60
            ]
            spot = near[0] if near else (failure.kind.value, column, row)
            spots.setdefault(spot, []).append(f"{failure.start_s:.1f}")
        lines: list[tuple[int, int]] = []
        for (kind, column, row), times in spots.items():
            line = row - 8
            while any(abs(column - x) < 180 and abs(line - y) < 15 for x, y in lines):
                line += 15
            lines.append((column, line))
            more = f" and {len(times) - 1} more" if len(times) > 1 else ""
            self._label(f"{kind} {times[0]} s{more}", column + 10, line, _FAILED)

    def _ground(self, world: World, width_px: int) -> Array:
        """The surfaces of the ground, shaded by its slope."""
        column, row = np.meshgrid(np.arange(width_px), np.arange(self._height))
        x = self._low[0] + column / self._scale
        y = self._low[1] + (self._height - 1 - row) / self._scale
        colour = surface_colours()[world.ground.surface_at(x, y)].astype(np.float64)
        normal = world.ground.normal_at(x, y)
        shade = 1 + 0.8 * (normal @ np.array([-0.5, 0.5, 0.0]))
        pale = 255 - 0.6 * (255 - colour)
        return np.asarray(np.clip(pale * shade[..., None], 0, 255), np.uint8)

    def _things(self, world: World) -> None:
        items = sorted(world.obstacles.items, key=lambda item: not item.pliable)
        for item in items:
            corners, fill = self.pixels(outline(item)), CLASS_COLOURS[obstacle_class(item)]
            if item.pliable:
                under = self.canvas.copy()
                cv2.fillPoly(under, [corners], fill, cv2.LINE_AA)
                cv2.addWeighted(under, 0.5, self.canvas, 0.5, 0.0, self.canvas)
            else:
                cv2.fillPoly(self.canvas, [corners], fill, cv2.LINE_AA)
            cv2.polylines(self.canvas, [corners], isClosed=True, color=INK, thickness=1, lineType=cv2.LINE_AA)
        for name, point in (("start", world.start_m), ("goal", world.goal_m)):
            column, row = self.pixels(np.array([point]))[0].tolist()
            cv2.drawMarker(self.canvas, (column, row), INK, cv2.MARKER_DIAMOND, 12, 2, cv2.LINE_AA)
            self._label(name, column + 9, row + 14, INK)
        length = round(_DISTANCE_M * self._scale)
        cv2.line(self.canvas, (12, self._height - 12), (12 + length, self._height - 12), INK, 2)
        write(self.canvas, f"{_DISTANCE_M:.0f} m", 16, self._height - 18)

    def _label(self, text: str, x: int, y: int, colour: Colour) -> None:
        """Write with a pale rim, within the canvas."""
        (width, _), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, 0.42, 1)
        x = min(x, self.canvas.shape[1] - width - 4)
        cv2.putText(self.canvas, text, (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.42, (255, 255, 255), 3, cv2.LINE_AA)
        write(self.canvas, text, x, y, colour=colour)
