"""What is true of a drive and its place, as the text of messages on /ground_truth/..."""

import json
from typing import NamedTuple

import numpy as np

from navtool.pipeline.arrays import Array
from navtool.sim.drive.drive import Drive
from navtool.sim.drive.failure import Failure
from navtool.sim.sensors.shader import SKY
from navtool.sim.world.height_field import HeightField
from navtool.sim.world.obstacle import Obstacle
from navtool.sim.world.place import World
from navtool.sim.world.surfaces import SURFACES

_CORNERS = 16
_TERRAIN_EVERY_S = 0.1


def nanoseconds(time_s: float) -> int:
    """Seconds as whole nanoseconds."""
    return round(time_s * 1e9)


def event_text(failure: Failure, start_ns: int) -> str:
    """A failure: kind, when it began and ended (stamps, and seconds from the drive's start), where it began, why."""
    return _json(
        {
            "kind": failure.kind.value,
            "start_ns": start_ns + nanoseconds(failure.start_s),
            "end_ns": start_ns + nanoseconds(failure.end_s),
            "start_s": round(failure.start_s, 6),
            "end_s": round(failure.end_s, 6),
            "x_m": round(failure.x_m, 4),
            "y_m": round(failure.y_m, 4),
            "reason": failure.reason,
        }
    )


def obstacles_text(world: World) -> str:
    """All that stands in the place: outlines in the map frame, counter-clockwise, and how each meets a robot."""
    return _json(
        {
            "frame_id": "map",
            "obstacles": [
                {
                    "kind": item.kind,
                    "surface": SURFACES[item.surface].name,
                    "class": obstacle_class(item),
                    "height_m": round(item.height_m, 4),
                    "outline_m": np.round(outline(item), 4).tolist(),
                }
                for item in world.obstacles.items
            ],
        }
    )


def obstacle_class(item: Obstacle) -> str:
    """MIM's classes: transparent, pliable or solid."""
    if SURFACES[item.surface].transmittance > 0:
        return "transparent"
    return "pliable" if item.pliable else "solid"


def outline(item: Obstacle) -> Array:
    """The corners of an outline [k, 2] in metres, counter-clockwise; a circle has 16, on the circle."""
    if item.half_width_m is None:
        angle = np.arange(_CORNERS) * (2 * np.pi / _CORNERS)
        local = item.half_length_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    else:
        local = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
        local = local * (item.half_length_m, item.half_width_m)
    cos, sin = np.cos(item.yaw_rad), np.sin(item.yaw_rad)
    return np.asarray(local @ np.array([[cos, sin], [-sin, cos]]) + (item.x_m, item.y_m))


class TerrainChange(NamedTuple):
    """From when on the robot's middle is above which surface."""

    time_s: float
    surface: int


def terrain_changes(drive: Drive, ground: HeightField) -> list[TerrainChange]:
    """The surface underneath at the start, and at each change, looked at ten times a second."""
    every = max(1, round(_TERRAIN_EVERY_S / float(drive.time_s[1])))
    position = drive.position_m[::every]
    surface = ground.surface_at(position[:, 0], position[:, 1])
    new = np.flatnonzero(np.diff(surface, prepend=np.uint8(SKY)))
    return [TerrainChange(float(drive.time_s[index * every]), int(surface[index])) for index in new.tolist()]


def terrain_text(change: TerrainChange, start_ns: int) -> str:
    """The surface underneath from a moment on, and its group of terrain."""
    surface = SURFACES[change.surface]
    stamp = start_ns + nanoseconds(change.time_s)
    return _json({"stamp_ns": stamp, "surface": surface.name, "group": surface.group.value})


def surfaces_text() -> str:
    """The names of the numbers in pictures of surfaces."""
    return _json({**{str(number): surface.name for number, surface in enumerate(SURFACES)}, str(SKY): "sky"})


def _json(content: object) -> str:
    return json.dumps(content, separators=(",", ":"), allow_nan=False)
