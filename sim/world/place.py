"""One place of a scenario: its ground, everything that stands there, and where a course begins and ends."""

import logging
from collections import Counter
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Float64
from scipy import ndimage

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.world.height_field import HeightField
from navtool.sim.world.kinds import KINDS, Spot
from navtool.sim.world.mesh import TriangleMesh, join_meshes
from navtool.sim.world.obstacle import Obstacle, Obstacles
from navtool.sim.world.randomness import Purpose, generator
from navtool.sim.world.room import build_room
from navtool.sim.world.scenario import Scatter, ScenarioConfig
from navtool.sim.world.surfaces import SURFACES
from navtool.sim.world.terrain import make_ground

logger = logging.getLogger(__name__)

FREE_M = 1.2
"""Start and goal are this far from everything that stands there."""
ROBOT_M = 0.4
"""Half the width of the way from start to goal that every place has through what does not yield."""
_BESIDE_M, _BEYOND_M = 11.0, 5.0
"""Things stand this far beside the straight course, and beyond its ends."""
_TRIES, _ATTEMPTS = 60, 12
_GRID_M = 0.2


@dataclass(frozen=True, slots=True)
class World:
    """One place. Right-handed world frame, x from start to goal, z up, metres; built once and never changed."""

    config: ScenarioConfig
    seed: int
    ground: HeightField
    mesh: TriangleMesh
    """Everything that a ray can meet: the ground first, then what stands on it."""
    obstacles: Obstacles
    """Outlines of what stands on the ground, whether it yields or not."""
    start_m: tuple[float, float]
    goal_m: tuple[float, float]
    sun: tuple[float, float, float]
    """Unit vector towards the sun."""
    placed: dict[str, int]
    """How many of each kind stand there."""
    left_out: dict[str, int]
    """How many of each kind the scenario wanted and found no room for."""


class _Placed(NamedTuple):
    things: list[tuple[str, Spot, int]]
    """Name of its kind, where it stands, and its number within the kind."""
    outlines: list[Obstacle]
    left_out: Counter[str]


def make_world(config: ScenarioConfig, seed: int) -> World:
    """The place of a scenario with a number.

    Guarantee: equal arguments give equal worlds, bit by bit, in every process; there is a way from start to goal for a
    robot of half width ``ROBOT_M`` that touches nothing but what yields.

    Raises:
        SimError: The seed is negative, or the scenario leaves no way from start to goal.
    """
    if seed < 0:
        raise SimError(f"the seed is {seed}", where=config.name, cure="use a seed of 0 or more")
    place = f"{config.name}/{config.split.name}"
    course = generator(place, seed, Purpose.COURSE)
    sideways = 0.25 * min(6.0, _half_extent(config)[1])
    start, goal = ((x * config.course_m / 2, float(course.uniform(-sideways, sideways))) for x in (-1, 1))
    room_outlines, room_meshes = (
        ([], []) if config.room is None else build_room(config.room, generator(place, seed, Purpose.ROOM))
    )
    for attempt in range(_ATTEMPTS):
        rng = generator(place, seed, Purpose.PLACEMENT, attempt)
        placed = _place(config, [start, goal], room_outlines, rng)
        if _reachable(config, Obstacles(tuple(placed.outlines)), start, goal):
            break
    else:
        what = f"no way from start to goal in {_ATTEMPTS} tries with seed {seed}"
        raise SimError(what, where=config.name, cure="ask for fewer things, or wider gaps between them")
    if placed.left_out:
        logger.warning("%s, seed %d: no room for %s", config.name, seed, dict(placed.left_out))
    ground = make_ground(config, place, seed)
    meshes = [ground.mesh(), *room_meshes, *(_stand(*thing, ground, place, seed) for thing in placed.things)]
    return World(
        config=config,
        seed=seed,
        ground=replace(ground, drag_per_m=_drag(ground, placed.outlines)),
        mesh=join_meshes(meshes),
        obstacles=Obstacles(tuple(placed.outlines)),
        start_m=start,
        goal_m=goal,
        sun=_sun(config, generator(place, seed, Purpose.LIGHT)),
        placed=dict(Counter(name for name, _, _ in placed.things)),
        left_out=dict(placed.left_out),
    )


def _half_extent(config: ScenarioConfig) -> tuple[float, float]:
    """Half the sides of the rectangle in which things stand."""
    if config.room is not None:
        return config.room.length_m / 2 - 0.3, config.room.width_m / 2 - 0.3
    edge = config.side_m / 2 - 1.0
    return min(config.course_m / 2 + _BEYOND_M, edge), min(_BESIDE_M, edge)


def _place(
    config: ScenarioConfig, ends: list[tuple[float, float]], standing: list[Obstacle], rng: np.random.Generator
) -> _Placed:
    """Find a spot for each thing, clear of its neighbours and of the course's ends."""
    half_x, half_y = _half_extent(config)
    placed = _Placed([], list(standing), Counter())
    reserved = np.array(ends).T
    for name, kind in KINDS.items():
        scatter: Scatter = getattr(config, name)
        for number in range(scatter.count):
            for _ in range(_TRIES):
                spot = _draw(scatter, half_x, half_y, rng)
                outlines = kind.outlines(spot)
                if _fits(outlines, scatter.gap_m, placed.outlines, reserved):
                    placed.things.append((name, spot, number))
                    placed.outlines.extend(outlines)
                    break
            else:
                placed.left_out[name] += 1
    return placed


def _draw(scatter: Scatter, half_x: float, half_y: float, rng: np.random.Generator) -> Spot:
    low, high = max(scatter.from_m, -half_x), min(scatter.to_m, half_x)
    x, y = rng.uniform(min(low, high), high), rng.uniform(-half_y, half_y)
    return Spot(
        float(x),
        float(y),
        float(rng.uniform(0, np.pi)),
        float(rng.uniform(scatter.size[0], scatter.size[1])),
        float(rng.random()),
    )


def _fits(
    outlines: tuple[Obstacle, ...], gap_m: float, standing: list[Obstacle], reserved: Float64[Array, "2 n"]
) -> bool:
    """Whether a thing's outlines keep their gap from what stands there, and stay off the course's ends."""
    if Obstacles(outlines).clearance(*reserved).min() < FREE_M:
        return False
    if not standing:
        return True
    points = np.concatenate([_rim(outline) for outline in outlines]).T
    reach = np.hypot(*(points - points.mean(axis=1, keepdims=True))).max() + max(gap_m, 0.0) + 4.0
    middle = points.mean(axis=1)
    near = tuple(
        item for item in standing if np.hypot(item.x_m - middle[0], item.y_m - middle[1]) < reach + _long(item)
    )
    return not near or float(Obstacles(near).clearance(*points).min()) >= gap_m


def _long(item: Obstacle) -> float:
    return item.half_length_m + (item.half_width_m or 0.0)


def _rim(item: Obstacle) -> Float64[Array, "n 2"]:
    """Points on an outline, at most 0.4 m apart on a rectangle, and its middle."""
    if item.half_width_m is None:
        angle = np.arange(16) * (np.pi / 8)
        rim = np.pad(item.half_length_m * np.column_stack([np.cos(angle), np.sin(angle)]), ((0, 1), (0, 0)))
        return np.asarray(rim + np.array([item.x_m, item.y_m]))
    along = np.linspace(-1, 1, 2 + int(item.half_length_m / 0.2)) * item.half_length_m
    points = np.concatenate([np.column_stack([along, np.full(len(along), s * item.half_width_m)]) for s in (-1, 1)])
    cos, sin = np.cos(item.yaw_rad), np.sin(item.yaw_rad)
    return np.asarray(points @ np.array([[cos, sin], [-sin, cos]]) + np.array([item.x_m, item.y_m]))


def _reachable(
    config: ScenarioConfig, obstacles: Obstacles, start: tuple[float, float], goal: tuple[float, float]
) -> bool:
    """Whether a robot comes from start to goal without touching what does not yield."""
    edge = config.side_m / 2 - 1.0
    axis = np.arange(-edge, edge, _GRID_M)
    x, y = np.meshgrid(axis, axis)
    blocked = np.zeros(x.shape, bool)
    for item in obstacles.only(pliable=False).items:
        reach = _long(item) + ROBOT_M
        low_x, low_y = np.searchsorted(axis, [item.x_m - reach, item.y_m - reach])
        high_x, high_y = np.searchsorted(axis, [item.x_m + reach, item.y_m + reach])
        window = slice(low_y, high_y), slice(low_x, high_x)
        blocked[window] |= Obstacles((item,)).clearance(x[window], y[window]) < ROBOT_M
    regions, _ = ndimage.label(~blocked)
    cells = [tuple(np.searchsorted(axis, [end[1], end[0]])) for end in (start, goal)]
    return bool(regions[cells[0]] == regions[cells[1]] != 0)


def _stand(name: str, spot: Spot, number: int, ground: HeightField, place: str, seed: int) -> TriangleMesh:
    """A thing's triangles where it stands."""
    kind = KINDS[name]
    mesh = kind.mesh(spot, generator(place, seed, kind.purpose, number))
    z = float(ground.height_at(np.array([spot.x_m]), np.array([spot.y_m]))[0])
    if kind.purpose is Purpose.GRASS:  # each blade follows the ground under it
        feet = mesh.vertices.reshape(-1, 5, 3)[:, :2].mean(axis=1).astype(np.float64)
        rise = ground.height_at(feet[:, 0] + spot.x_m, feet[:, 1] + spot.y_m) - z
        lifted = mesh.vertices.reshape(-1, 5, 3) + np.stack([0 * rise, 0 * rise, rise], axis=-1)[:, None]
        mesh = mesh._replace(vertices=lifted.reshape(-1, 3).astype(np.float32))
    return mesh.moved(spot.x_m, spot.y_m, z)


def _drag(ground: HeightField, outlines: list[Obstacle]) -> Float32[Array, "n n"]:
    """The drag of the ground's surfaces, and of what grows or hangs over each cell, whichever is more."""
    drag = ground.drag_per_m.copy()
    side = len(drag)
    axis = (np.arange(side) + 0.5 - side / 2) * ground.cell_m
    for item in outlines:
        strength = np.float32(SURFACES[item.surface].drag_per_m)
        if strength == 0:
            continue
        low_x, high_x = np.searchsorted(axis, [item.x_m - _long(item), item.x_m + _long(item)])
        low_y, high_y = np.searchsorted(axis, [item.y_m - _long(item), item.y_m + _long(item)])
        x, y = np.meshgrid(axis[low_x:high_x], axis[low_y:high_y])
        window = drag[low_y:high_y, low_x:high_x]
        np.maximum(window, strength, out=window, where=Obstacles((item,)).clearance(x, y) < 0)
    return drag


def _sun(config: ScenarioConfig, rng: np.random.Generator) -> tuple[float, float, float]:
    lowest, highest = config.light.sun_elevation_rad
    azimuth, elevation = rng.uniform(0, 2 * np.pi), rng.uniform(lowest, highest)
    flat = np.cos(elevation)
    return float(flat * np.cos(azimuth)), float(flat * np.sin(azimuth)), float(np.sin(elevation))
