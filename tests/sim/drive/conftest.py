"""Places for drives."""

from collections.abc import Callable

import pytest

from navtool.configs.schema import config_folder
from navtool.sim.world.place import World, make_world
from navtool.sim.world.scenario import load_scenario


@pytest.fixture(scope="session")
def scenario_world() -> Callable[[str, int], World]:
    """A function that makes the place of a scenario with a number, each only once."""
    made: dict[tuple[str, int], World] = {}

    def make(name: str, seed: int) -> World:
        if (name, seed) not in made:
            made[name, seed] = make_world(load_scenario(config_folder() / "scenario" / f"{name}.yaml"), seed)
        return made[name, seed]

    return make
