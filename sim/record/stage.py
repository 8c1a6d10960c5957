"""A place made ready for sensors: its triangles in Embree, sun and sky cast."""

from typing import NamedTuple

from navtool.sim.sensors.shader import Shader
from navtool.sim.world.place import World, make_world
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import ScenarioConfig


class Stage(NamedTuple):
    """A place as robots and sensors need it."""

    world: World
    scene: RayScene
    shader: Shader


def set_stage(world: World) -> Stage:
    """Make a place ready; takes a second or two."""
    scene = RayScene(world.mesh)
    return Stage(world, scene, Shader(world, scene))


def make_stage(scenario: ScenarioConfig, seed: int) -> Stage:
    """The place of a scenario with a number.

    Raises:
        SimError: As `make_world`.
    """
    return set_stage(make_world(scenario, seed))
