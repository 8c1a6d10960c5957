"""An outdoor place: what stands in it, what it is made of, where the sun is. Drawn from a seed."""

from dataclasses import dataclass
from zlib import crc32

import numpy as np
from jaxtyping import Float

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.ground import Ground, make_ground
from navtool.sim.shapes import Box, Cylinder, Ellipsoid, Shape

REACH_M = 16.0
"""Half the side of the square in which things stand and the robot drives."""


@dataclass(frozen=True, slots=True)
class Material:
    """How a body looks, how it returns laser light and how it resists a robot."""

    colour: tuple[float, float, float]
    """Linear RGB, 0-255."""
    contrast: float
    """Depth of the procedural texture, 0-1."""
    reflectivity: float
    """Share of the laser light that comes back at perpendicular incidence, 0-1."""
    scatter_per_m: float = 0.0
    """Mean number of leaves a laser beam meets per metre; 0 for a solid body."""
    drag_per_m: float = 0.0
    """Share of its speed a robot loses per metre of penetration; only for bodies that scatter."""

    @property
    def solid(self) -> bool:
        """Whether a robot hits the body rather than driving into it."""
        return self.scatter_per_m == 0.0


BARK = Material((92.0, 72.0, 54.0), 0.7, 0.35)
METAL = Material((150.0, 152.0, 150.0), 0.15, 0.75)
STONE = Material((132.0, 126.0, 116.0), 0.5, 0.45)
BRICK = Material((150.0, 98.0, 78.0), 0.35, 0.4)
LEAVES = Material((72.0, 104.0, 44.0), 0.9, 0.55, scatter_per_m=2.5)
BUSH = Material((54.0, 84.0, 38.0), 0.9, 0.5, scatter_per_m=3.5, drag_per_m=1.6)
TALL_GRASS = Material((150.0, 142.0, 76.0), 0.9, 0.45, scatter_per_m=1.8, drag_per_m=0.25)


@dataclass(frozen=True, slots=True)
class Thing:
    """A body of one material."""

    shape: Shape
    material: Material

    @property
    def in_the_way(self) -> bool:
        """Whether a robot on the ground can meet it; a crown overhead is not in the way."""
        return self.shape.centre[2] - self.shape.half_extent[2] < 0.5


@dataclass(frozen=True, slots=True)
class Scene:
    """A place: ground, things on it, sun and horizon. Right-handed world frame, x and y level, z up, metres."""

    ground: Ground
    things: tuple[Thing, ...]
    sun: tuple[float, float, float]
    """Unit vector towards the sun."""
    treeline_rad: Float[Array, "720"]
    """Elevation of the far treeline per half degree of azimuth."""

    def corners(self) -> Float[Array, "things 8 3"]:
        """Return the corners of each thing's upright bounding box."""
        signs = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        centres = np.array([thing.shape.centre for thing in self.things]).reshape(-1, 1, 3)
        extents = np.array([thing.shape.half_extent for thing in self.things]).reshape(-1, 1, 3)
        return np.asarray(centres + signs * extents)

    def obstacles(self) -> tuple[Thing, ...]:
        """Return the things a robot can meet."""
        return tuple(thing for thing in self.things if thing.in_the_way)


def place_rng(seed: int, place: str) -> np.random.Generator:
    """Return a generator that depends on the seed and on the place's name alone."""
    if seed < 0:
        raise SimError(f"the seed is {seed}", where=place, cure="use a seed of 0 or more")
    return np.random.default_rng([seed, crc32(place.encode())])


def make_scene(seed: int, place: str) -> Scene:
    """Draw the place called ``place``.

    Guarantee: equal arguments give equal scenes, in every process.

    Raises:
        SimError: The seed is negative.
    """
    rng = place_rng(seed, place)
    azimuth, elevation = rng.uniform(0, 2 * np.pi), rng.uniform(0.5, 1.1)
    flat = np.cos(elevation)
    sun = (float(flat * np.cos(azimuth)), float(flat * np.sin(azimuth)), float(np.sin(elevation)))
    things = _scatter_things(rng)
    angles = np.arange(720) * (np.pi / 360)
    waves = sum(
        rng.uniform(0.2, 1.0) / k * np.sin(k * angles + rng.uniform(0, 6.3)) for k in (2, 3, 5, 8, 13, 21, 34, 55, 89)
    )
    treeline = np.clip(0.07 + 0.025 * np.asarray(waves) + rng.normal(0.0, 0.004, 720), 0.01, None)
    ground = make_ground(rng, [(thing.shape, thing.material.solid) for thing in things], sun)
    return Scene(ground=ground, things=tuple(things), sun=sun, treeline_rad=treeline)


def _scatter_things(rng: np.random.Generator) -> list[Thing]:
    """Place things without overlap and with gaps a robot fits through."""
    things: list[Thing] = []
    wanted = {
        "wall": int(rng.integers(1, 4)),
        "tree": int(rng.integers(12, 20)),
        "bush": int(rng.integers(12, 20)),
        "tall grass": int(rng.integers(8, 16)),
        "rock": int(rng.integers(5, 10)),
        "pole": int(rng.integers(2, 6)),
    }
    for kind, count in wanted.items():
        for _ in range(count):
            for _attempt in range(20):
                x, y = rng.uniform(-REACH_M, REACH_M, 2)
                candidate = _make_thing(kind, float(x), float(y), rng)
                if _is_free(candidate[0].shape, things):
                    things.extend(candidate)
                    break
    return things


def _is_free(shape: Shape, things: list[Thing], gap_m: float = 1.2) -> bool:
    corners = np.array([[-1, -1, 1, 1, 0], [-1, 1, -1, 1, 0]]) * np.array(shape.half_extent[:2])[:, None]
    outline = corners + np.array(shape.centre[:2])[:, None]
    return all(thing.shape.clearance(outline).min() > gap_m for thing in things if thing.in_the_way)


def _make_thing(kind: str, x: float, y: float, rng: np.random.Generator) -> list[Thing]:
    """Return the bodies of one thing of random size; the first one stands on the ground."""
    match kind:
        case "tree":
            crown, lift = rng.uniform(1.0, 2.0), rng.uniform(1.6, 2.2)
            trunk = Cylinder(x, y, rng.uniform(0.09, 0.24), lift + 0.8 * crown)
            leaves = Ellipsoid(x, y, lift + 1.1 * crown, crown, 1.1 * crown)
            return [Thing(trunk, BARK), Thing(leaves, LEAVES)]
        case "bush":
            radius, height = rng.uniform(0.6, 1.1), rng.uniform(0.5, 0.9)
            return [Thing(Ellipsoid(x, y, 0.6 * height, radius, height), BUSH)]
        case "tall grass":
            return [Thing(Ellipsoid(x, y, 0.05, rng.uniform(0.5, 1.2), rng.uniform(0.35, 0.6)), TALL_GRASS)]
        case "rock":
            radius = rng.uniform(0.3, 0.7)
            return [Thing(Ellipsoid(x, y, 0.1 * radius, radius, radius * rng.uniform(0.7, 1.0)), STONE)]
        case "pole":
            return [Thing(Cylinder(x, y, rng.uniform(0.04, 0.08), rng.uniform(1.5, 4.0)), METAL)]
        case _:
            size = rng.uniform(1.5, 3.5), rng.uniform(0.12, 0.25), rng.uniform(1.0, 2.4)
            return [Thing(Box(x, y, *size, rng.uniform(0, np.pi)), BRICK)]
