from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.world.height_field import SKIRT_M, SKIRT_TRIANGLES, HeightField
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.surfaces import SURFACES, surface_number

type FieldOf = Callable[[Array], HeightField]


def plane(slope_x: float, slope_y: float, side: int = 8) -> Array:
    """A plane with a level rim around it."""
    axis = (np.arange(side + 1) - side / 2) * 0.5
    x, y = np.meshgrid(axis, axis)
    return np.asarray(rimmed(0.3 + slope_x * x + slope_y * y))


def rimmed(heights: Array) -> Array:
    """The heights with 0 at the edge."""
    return np.pad(heights[1:-1, 1:-1], 1)


@given(slope_x=st.floats(-1, 1), slope_y=st.floats(-1, 1), seed=st.integers(0, 100))
def test_a_plane_is_met_exactly(slope_x: float, slope_y: float, seed: int) -> None:
    heights = plane(slope_x, slope_y)
    side = len(heights) - 1
    field = HeightField(0.5, heights, np.zeros((side, side), np.uint8), np.zeros((side, side), np.float32))
    x, y = np.random.default_rng(seed).uniform(-1.5, 1.5, (2, 50))
    assert field.height_at(x, y) == pytest.approx(0.3 + slope_x * x + slope_y * y, abs=1e-12)
    normal = np.array([-slope_x, -slope_y, 1.0]) / np.sqrt(1 + slope_x**2 + slope_y**2)
    assert field.normal_at(x, y) == pytest.approx(np.tile(normal, (50, 1)), abs=1e-12)


def test_a_ray_from_above_finds_the_height_and_surface_that_a_foot_feels(field_of: FieldOf) -> None:
    rng = np.random.default_rng(0)
    field = field_of(rimmed(rng.normal(0, 0.3, (9, 9))))
    mesh = field.mesh()
    x, y = rng.uniform(-2, 2, (2, 400))
    origins = np.stack([x, y, np.full(400, 5.0)], axis=1).astype(np.float32)
    hits = RayScene(mesh).cast(origins, np.tile(np.array([[0, 0, -1]], np.float32), (400, 1)))
    assert 5 - hits.distance_m == pytest.approx(field.height_at(x, y), abs=1e-5)
    inner = (np.abs(x / 0.5 - np.round(x / 0.5)) > 1e-3) & (np.abs(y / 0.5 - np.round(y / 0.5)) > 1e-3)
    assert (mesh.surface[hits.triangle] == field.surface_at(x, y))[inner].all()
    diagonal = np.abs((x - y) / 0.5 - np.round((x - y) / 0.5)) < 1e-3
    assert mesh.normals()[hits.triangle][inner & ~diagonal] == pytest.approx(
        field.normal_at(x, y)[inner & ~diagonal], abs=1e-5
    )


def test_heights_go_on_without_a_step(field_of: FieldOf) -> None:
    field = field_of(rimmed(np.random.default_rng(1).normal(0, 0.3, (9, 9))))
    x, y = np.random.default_rng(2).uniform(-1.9, 1.9, (2, 1000))
    steepest = np.abs(np.diff(field.heights_m, axis=0)).max() + np.abs(np.diff(field.heights_m, axis=1)).max()
    moved = field.height_at(x + 1e-6, y - 1e-6) - field.height_at(x, y)
    assert np.abs(moved).max() < 2e-6 * steepest / 0.5 + 1e-12


def test_beyond_the_edge_everything_is_as_on_it(field_of: FieldOf) -> None:
    field = field_of(rimmed(np.random.default_rng(3).normal(0, 0.3, (9, 9))))
    inside, outside = np.array([2.0, 0.3, -2.0]), np.array([9.0, 0.3, -50.0])
    assert field.height_at(outside, inside) == pytest.approx(field.height_at(inside, inside))
    assert (field.surface_at(outside, inside) == field.surface_at(inside, inside)).all()


def test_the_mesh_looks_up_and_goes_on_beyond_the_grid(field_of: FieldOf) -> None:
    field = field_of(rimmed(np.random.default_rng(4).normal(0, 0.1, (9, 9))))
    mesh = field.mesh()
    assert (mesh.normals()[:, 2] > 0).all()
    x, y = np.random.default_rng(5).uniform(-SKIRT_M, SKIRT_M, (2, 2000))
    origins = np.stack([x, y, np.full(2000, 3.0)], axis=1).astype(np.float32)
    hits = RayScene(mesh).cast(origins, np.tile(np.array([[0, 0, -1]], np.float32), (2000, 1)))
    assert (hits.triangle >= 0).all(), "no gap"
    outside = np.maximum(np.abs(x), np.abs(y)) > 2
    assert hits.distance_m[outside] == pytest.approx(np.full(outside.sum(), 3.0), abs=1e-5)
    assert (hits.triangle[outside] >= len(mesh.triangles) - SKIRT_TRIANGLES).all()


def test_an_edge_that_is_not_level_is_refused(field_of: FieldOf) -> None:
    with pytest.raises(ValueError, match="at its edge"):
        field_of(np.ones((9, 9)))


def test_contact_numbers_are_those_of_the_surface(field_of: FieldOf) -> None:
    field = field_of(np.zeros((9, 9)))
    x, y = np.array([-1.75, -1.25]), np.array([-1.75, -1.75])  # cells of concrete and asphalt
    concrete, asphalt = (SURFACES[surface_number(name)] for name in ("concrete", "asphalt"))
    assert concrete.friction != asphalt.friction
    assert field.contact_at(x, y, "friction") == pytest.approx([concrete.friction, asphalt.friction])
    assert field.contact_at(x, y, "stiffness_npm") == pytest.approx([concrete.stiffness_npm, asphalt.stiffness_npm])
