"""Small grounds and places."""

from collections.abc import Callable

import numpy as np
import pytest

from navtool.pipeline.arrays import Array
from navtool.sim.world.height_field import HeightField
from navtool.sim.world.scenario import RegionConfig, RegionShape, Scatter, ScenarioConfig


@pytest.fixture
def field_of() -> Callable[[Array], HeightField]:
    """A factory of height fields with cells of 0.5 m from the heights of their nodes."""

    def make(heights: Array) -> HeightField:
        side = len(heights) - 1
        return HeightField(
            cell_m=0.5,
            heights_m=heights.astype(np.float64),
            surface=(np.arange(side * side) % 8).astype(np.uint8).reshape(side, side),
            drag_per_m=np.zeros((side, side), np.float32),
        )

    return make


@pytest.fixture(scope="session")
def small_scenario() -> ScenarioConfig:
    """Some of everything on 24 m x 24 m."""
    return ScenarioConfig(
        name="small",
        side_m=24.0,
        cell_m=0.2,
        course_m=12.0,
        regions=[
            RegionConfig(surface="rock_bed", share=0.3, size_m=4.0),
            RegionConfig(surface="concrete", shape=RegionShape.path, size_m=2.0),
        ],
        trees=Scatter(count=4),
        hanging_trees=Scatter(count=2),
        bushes=Scatter(count=4),
        grass_patches=Scatter(count=4, gap_m=0.0),
        rocks=Scatter(count=3),
        walls=Scatter(count=1),
        pillars=Scatter(count=2),
        glass_panels=Scatter(count=1),
        curtains=Scatter(count=1),
    )
