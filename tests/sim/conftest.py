"""Factories of small worlds."""

from collections.abc import Callable

import numpy as np
import pytest

from navtool.sim.ground import HALF_SIDE_M, TEXEL_M, Ground, Terrain
from navtool.sim.scene import Scene, Thing, make_scene


@pytest.fixture(scope="session")
def flat_scene() -> Callable[..., Scene]:
    """A factory of scenes with given things on an even path under a high sun."""

    def make(*things: Thing) -> Scene:
        side = round(2 * HALF_SIDE_M / TEXEL_M)
        colour = np.full((side, side, 4), (120, 110, 90, 0), np.uint8)
        terrain = np.full((side, side), Terrain.PATH, np.uint8)
        ground = Ground(terrain=terrain, colour=colour, detail=np.full((64, 64), 128, np.uint8))
        return Scene(ground=ground, things=things, sun=(0.0, 0.6, 0.8), treeline_rad=np.full(720, 0.01))

    return make


@pytest.fixture(scope="session")
def place() -> Scene:
    """A whole place."""
    return make_scene(1, "place-a")
