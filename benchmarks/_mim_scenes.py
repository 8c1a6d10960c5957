"""Closed rooms with one thing in them that an intensity map is asked about."""

from dataclasses import replace

import numpy as np
from _mim_drives import Place, place_of

from navtool.sim.world import structures
from navtool.sim.world.kinds import Spot, long_outline
from navtool.sim.world.mesh import TriangleMesh, join_meshes
from navtool.sim.world.obstacle import Obstacle, Obstacles
from navtool.sim.world.place import make_world
from navtool.sim.world.scenario import RoomConfig, ScenarioConfig

LINTEL_M = 2.1


def room_with(
    length_m: float, width_m: float, seed: int, things: list[tuple[Obstacle, TriangleMesh]], over: list[TriangleMesh]
) -> Place:
    """A room about the origin with things in it, and with what hangs above head height."""
    room = RoomConfig(length_m=length_m, width_m=width_m)
    config = ScenarioConfig(name="room", side_m=24.0, course_m=4.0, ground="concrete", hills_m=0.0, room=room)
    world = make_world(config, seed)
    items = (*world.obstacles.items, *(outline for outline, _ in things))
    mesh = join_meshes([world.mesh, *(mesh for _, mesh in things), *over])
    return place_of(replace(world, obstacles=Obstacles(items), mesh=mesh))


def pane(x_m: float, y_m: float, yaw_rad: float, half_m: float) -> tuple[Obstacle, TriangleMesh]:
    """A pane of glass from the floor to above the robot."""
    spot = Spot(x_m, y_m, yaw_rad, 0.0, 0.0)
    outline = long_outline(spot, "glass", "glass", half_m, structures.GLASS_THICKNESS_M / 2, 2.2)
    return outline, structures.make_pane(half_m, 2.2, yaw_rad).moved(x_m, y_m, 0.0)


def wall(y_from_m: float, y_to_m: float) -> tuple[Obstacle, TriangleMesh]:
    """A piece of wall across the room, at x = 0."""
    half, middle = (y_to_m - y_from_m) / 2, (y_to_m + y_from_m) / 2
    outline = long_outline(Spot(0.0, middle, np.pi / 2, 0.0, 0.0), "wall", "plaster", half, 0.06, 2.8)
    return outline, structures.make_wall(half, 0.06, 2.8, np.pi / 2, "plaster").moved(0.0, middle, 0.0)


def lintel(y_m: float, half_m: float) -> TriangleMesh:
    """The wall above a door."""
    over = structures.make_wall(half_m, 0.06, 2.8 - LINTEL_M - 0.15, np.pi / 2, "plaster")
    return over.moved(0.0, y_m, LINTEL_M + 0.15)
