"""Scenes of a few large triangles, and poses of sensors in them."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from navtool.pipeline.arrays import Array
from navtool.sim.world.mesh import TriangleMesh, join_meshes, make_mesh
from navtool.sim.world.place import World, make_world
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import LightConfig, ScenarioConfig
from navtool.sim.world.surfaces import surface_number


def sheet(corners: list[list[float]], surface: str) -> TriangleMesh:
    """A flat four-cornered sheet."""
    return make_mesh(np.array(corners), np.array([[0, 1, 2], [0, 2, 3]]), surface_number(surface))


@pytest.fixture(scope="session")
def ground() -> TriangleMesh:
    """Level concrete at z = 0 as far as any beam reaches."""
    return sheet([[-500, -500, 0], [500, -500, 0], [500, 500, 0], [-500, 500, 0]], "concrete")


@pytest.fixture(scope="session")
def wall_at() -> Callable[..., TriangleMesh]:
    """A factory of upright sheets across the x axis: at x, from y to y, up to a height, of a surface."""

    def make(
        x: float,
        surface: str = "concrete",
        y: tuple[float, float] = (-300.0, 300.0),
        z: tuple[float, float] = (-200.0, 200.0),
    ) -> TriangleMesh:
        return sheet([[x, y[0], z[0]], [x, y[1], z[0]], [x, y[1], z[1]], [x, y[0], z[1]]], surface)

    return make


@pytest.fixture(scope="session")
def scene_of() -> Callable[..., RayScene]:
    """A factory of scenes from meshes."""
    return lambda *meshes: RayScene(join_meshes(list(meshes)))


@pytest.fixture(scope="session")
def standing() -> Callable[..., Array]:
    """A factory of the poses of a sensor that does not move: its height and how often."""

    def make(height_m: float, count: int, x_m: float = 0.0, y_m: float = 0.0) -> Array:
        pose = np.eye(4)
        pose[:3, 3] = x_m, y_m, height_m
        return np.broadcast_to(pose, (count, 4, 4))

    return make


@pytest.fixture(scope="session")
def world_of() -> Callable[..., World]:
    """A factory of worlds of level concrete, with meshes on it and under a light of choice."""

    def make(*meshes: TriangleMesh, light: LightConfig | None = None, ground: str = "concrete") -> World:
        light = light if light is not None else LightConfig(sun_elevation_rad=[0.8, 0.8])
        config = ScenarioConfig(side_m=20.0, cell_m=0.5, course_m=6.0, hills_m=0.0, ground=ground, light=light)
        world = make_world(config, 0)
        level = replace(world.ground, heights_m=np.zeros_like(world.ground.heights_m))
        return replace(world, ground=level, mesh=join_meshes([level.mesh(), *meshes]), sun=(0.0, -0.6, 0.8))

    return make
