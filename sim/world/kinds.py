"""The kinds of things that can be scattered about a place: their outlines and their meshes."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from navtool.sim.world import structures, trees, vegetation
from navtool.sim.world.mesh import TriangleMesh, join_meshes
from navtool.sim.world.obstacle import Obstacle
from navtool.sim.world.randomness import Purpose
from navtool.sim.world.surfaces import surface_number


class Spot(NamedTuple):
    """Where one thing stands and which of its kind it is."""

    x_m: float
    y_m: float
    yaw_rad: float
    size: float
    """0-1 within the range of its kind."""
    variant: float
    """0-1: decides between the materials of its kind."""


class Kind(NamedTuple):
    """A kind of thing."""

    purpose: Purpose
    outlines: Callable[[Spot], tuple[Obstacle, ...]]
    """Its outlines; the first one is the widest."""
    mesh: Callable[[Spot, np.random.Generator], TriangleMesh]
    """Its triangles about the origin, turned but not moved."""


def round_outline(spot: Spot, kind: str, surface: str, radius_m: float, height_m: float) -> Obstacle:
    """A circle at a spot."""
    number = surface_number(surface)
    return Obstacle(kind=kind, surface=number, x_m=spot.x_m, y_m=spot.y_m, half_length_m=radius_m, height_m=height_m)


def long_outline(spot: Spot, kind: str, surface: str, length_m: float, width_m: float, height_m: float) -> Obstacle:
    """A rectangle at a spot, by its half length and half width."""
    return Obstacle(
        kind=kind,
        surface=surface_number(surface),
        x_m=spot.x_m,
        y_m=spot.y_m,
        half_length_m=length_m,
        half_width_m=width_m,
        yaw_rad=spot.yaw_rad,
        height_m=height_m,
    )


def _tree(spot: Spot) -> tuple[Obstacle, ...]:
    return (round_outline(spot, "trunk", "bark", trees.trunk_radius_m(spot.size), 3.5 + 3.5 * spot.size),)


def _hanging_tree(spot: Spot) -> tuple[Obstacle, ...]:
    leaves = round_outline(spot, "hanging_leaves", "leaf", 0.9 + 0.9 * spot.size, 3.5 + 3.5 * spot.size)
    return leaves, *_tree(spot)


def _wall_size(spot: Spot) -> tuple[float, float, float]:
    return 1.2 + 1.6 * spot.size, 0.10 + 0.05 * spot.variant, 1.0 + 1.4 * spot.size


def _wall_surface(spot: Spot) -> str:
    return "brick" if spot.variant < 0.5 else "concrete"


def _pillar(spot: Spot) -> tuple[float, float, str]:
    """Radius, height and surface."""
    if spot.variant < 0.5:
        return 0.15 + 0.15 * spot.size, 2.7, "concrete"
    return 0.035 + 0.04 * spot.size, 2.2 + 1.8 * spot.size, "steel"


def _pillar_outline(spot: Spot) -> tuple[Obstacle, ...]:
    radius, height, surface = _pillar(spot)
    return (round_outline(spot, "pillar", surface, radius, height),)


def _pillar_mesh(spot: Spot, _: np.random.Generator) -> TriangleMesh:
    return structures.make_pole(*_pillar(spot))


def _pane_half_length(spot: Spot) -> float:
    return 0.7 + 0.9 * spot.size


def _curtain_half_length(spot: Spot) -> float:
    return 0.5 + 0.4 * spot.size


def _curtain_poles(spot: Spot) -> list[Spot]:
    reach = _curtain_half_length(spot) + 0.04
    x, y = reach * np.cos(spot.yaw_rad), reach * np.sin(spot.yaw_rad)
    return [spot._replace(x_m=spot.x_m + sign * float(x), y_m=spot.y_m + sign * float(y)) for sign in (-1, 1)]


def _curtain(spot: Spot) -> tuple[Obstacle, ...]:
    poles = tuple(round_outline(pole, "pillar", "steel", 0.03, 2.2) for pole in _curtain_poles(spot))
    return (
        long_outline(spot, "curtain", "bead", _curtain_half_length(spot), 0.04, structures.CURTAIN_M),
        *poles,
    )


def _curtain_mesh(spot: Spot, rng: np.random.Generator) -> TriangleMesh:
    poles = [
        structures.make_pole(0.03, 2.2, "steel").moved(pole.x_m - spot.x_m, pole.y_m - spot.y_m, 0.0)
        for pole in _curtain_poles(spot)
    ]
    return join_meshes([structures.make_curtain(_curtain_half_length(spot), spot.yaw_rad, rng), *poles])


KINDS: dict[str, Kind] = {
    "trees": Kind(Purpose.TREES, _tree, lambda spot, rng: trees.make_tree(spot.size, rng)),
    "hanging_trees": Kind(
        Purpose.HANGING_TREES, _hanging_tree, lambda spot, rng: trees.make_tree(spot.size, rng, hanging=True)
    ),
    "walls": Kind(
        Purpose.WALLS,
        lambda spot: (long_outline(spot, "wall", _wall_surface(spot), *_wall_size(spot)),),
        lambda spot, _: structures.make_wall(*_wall_size(spot), spot.yaw_rad, _wall_surface(spot)),
    ),
    "glass_panels": Kind(
        Purpose.GLASS,
        lambda spot: (
            long_outline(spot, "glass", "glass", _pane_half_length(spot), structures.GLASS_THICKNESS_M / 2, 2.2),
        ),
        lambda spot, _: structures.make_pane(_pane_half_length(spot), 2.2, spot.yaw_rad),
    ),
    "curtains": Kind(Purpose.CURTAINS, _curtain, _curtain_mesh),
    "bushes": Kind(
        Purpose.BUSHES,
        lambda spot: (
            round_outline(
                spot,
                "bush",
                "bush_leaf",
                vegetation.bush_radius_m(spot.size),
                vegetation.bush_height_m(spot.size),
            ),
        ),
        lambda spot, rng: vegetation.make_bush(spot.size, rng),
    ),
    "rocks": Kind(
        Purpose.ROCKS,
        lambda spot: (
            round_outline(
                spot, "rock", "rock", structures.rock_radius_m(spot.size), 0.9 * structures.rock_radius_m(spot.size)
            ),
        ),
        lambda spot, rng: structures.make_rock(spot.size, rng),
    ),
    "pillars": Kind(Purpose.PILLARS, _pillar_outline, _pillar_mesh),
    "grass_patches": Kind(
        Purpose.GRASS,
        lambda spot: (round_outline(spot, "grass_patch", "tall_grass", vegetation.patch_radius_m(spot.size), 0.9),),
        lambda spot, rng: vegetation.make_grass_patch(spot.size, rng),
    ),
}
"""Every kind that a scenario can scatter, by the name of its field, in the order of placing."""
