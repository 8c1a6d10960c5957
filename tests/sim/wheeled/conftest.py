"""Small places made by hand, and drives in them."""

from collections.abc import Callable, Sequence

import numpy as np
import pytest

from navtool.pipeline.arrays import Array
from navtool.sim.wheeled.robot import WheeledRobot
from navtool.sim.world.height_field import HeightField
from navtool.sim.world.mesh import TriangleMesh
from navtool.sim.world.obstacle import Obstacle, Obstacles
from navtool.sim.world.place import World
from navtool.sim.world.scenario import ScenarioConfig
from navtool.sim.world.surfaces import surface_number, surface_values

CELLS, CELL_M = 240, 0.1
Place = Callable[..., World]
Order = tuple[float, float, float]


@pytest.fixture(scope="session")
def place() -> Place:
    """A factory of places of 24 m x 24 m.

    It takes the surface by name or by cell, heights as a function of x and y (pressed down to 0 at the very edge),
    obstacles, and the mesh of what grows there.
    """

    def make(
        surface: str | Array = "concrete",
        height: Callable[[Array, Array], Array] | None = None,
        things: Sequence[Obstacle] = (),
        mesh: TriangleMesh | None = None,
    ) -> World:
        axis = (np.arange(CELLS + 1) - CELLS / 2) * CELL_M
        x, y = np.meshgrid(axis, axis)
        heights = np.zeros(x.shape) if height is None else np.asarray(height(x, y), np.float64).copy()
        heights[[0, -1]] = 0.0
        heights[:, [0, -1]] = 0.0
        number = np.full((CELLS, CELLS), surface_number(surface)) if isinstance(surface, str) else surface
        ground = HeightField(
            cell_m=CELL_M,
            heights_m=heights,
            surface=number.astype(np.uint8),
            drag_per_m=surface_values("drag_per_m")[number],
        )
        return World(
            config=ScenarioConfig(name="by hand", side_m=24.0, course_m=16.0),
            seed=0,
            ground=ground,
            mesh=ground.mesh() if mesh is None else mesh,
            obstacles=Obstacles(tuple(things)),
            start_m=(-8.0, 0.0),
            goal_m=(8.0, 0.0),
            sun=(0.0, 0.0, 1.0),
            placed={},
            left_out={},
        )

    return make


@pytest.fixture(scope="session")
def run() -> Callable[..., WheeledRobot]:
    """A function that lets a robot follow orders of duration, speed and turn in a place."""

    def drive(
        world: World, *orders: Order, start: tuple[float, float, float] = (0.0, 0.0, 0.0), freed: bool = False
    ) -> WheeledRobot:
        robot = WheeledRobot(world)
        robot.reset(*start)
        for duration_s, speed_mps, turn_radps in orders:
            robot.step(speed_mps, turn_radps, duration_s, freed=freed)
        return robot

    return drive
