import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.sim.world.mesh import join_meshes, make_mesh
from navtool.sim.world.primitives import box, sphere_points
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.structures import make_pane
from navtool.sim.world.surfaces import surface_number

CENTRE, RADIUS = np.array([6.0, 1.0, 0.5]), 1.5


def sphere_scene() -> RayScene:
    vertices, triangles = sphere_points(5)
    return RayScene(make_mesh(vertices * RADIUS + CENTRE, triangles, surface_number("rock")))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_rays_meet_a_sphere_where_the_equation_says(seed: int) -> None:
    rng = np.random.default_rng(seed)
    towards = CENTRE + rng.normal(0, 1.0, (200, 3))
    directions = towards / np.linalg.norm(towards, axis=1, keepdims=True)
    hits = sphere_scene().cast(np.zeros((200, 3), np.float32), directions.astype(np.float32))
    along = directions @ CENTRE
    under = along**2 - (CENTRE @ CENTRE - RADIUS**2)
    clear = under > 0.1  # the facets lie a little inside the sphere: leave grazing rays out
    assert hits.distance_m[clear] == pytest.approx((along - np.sqrt(np.maximum(under, 0)))[clear], abs=4e-3)
    assert np.isinf(hits.distance_m[under < 0]).all()
    assert (hits.triangle[under < 0] == -1).all()


def test_normals_and_surfaces_are_those_of_the_triangle_that_is_met() -> None:
    scene = sphere_scene()
    hits = scene.cast(np.zeros((1, 3), np.float32), (CENTRE / np.linalg.norm(CENTRE))[None].astype(np.float32))
    assert scene.normals[hits.triangle[0]] == pytest.approx(-CENTRE / np.linalg.norm(CENTRE), abs=0.05)
    assert scene.surface[hits.triangle[0]] == surface_number("rock")


def test_what_lies_behind_glass_is_the_second_hit() -> None:
    wall = box(0.1, 2.0, 2.0, 0.0, surface_number("brick")).moved(7.0, 0.0, 0.0)
    scene = RayScene(join_meshes([make_pane(2.0, 2.0, np.pi / 2).moved(4.0, 0.0, 0.0), wall]))
    origins = np.tile(np.array([[0.0, 0.1, 1.0]], np.float32), (2, 1))
    directions = np.array([[1, 0, 0], [-1, 0, 0]], np.float32)
    first = scene.cast(origins, directions)
    assert first.distance_m.tolist() == pytest.approx([4.0, np.inf])
    assert scene.surface[first.triangle[0]] == surface_number("glass")
    second = scene.cast_on(origins[:1], directions[:1], first.distance_m[:1])
    assert second.distance_m[0] == pytest.approx(6.9, abs=1e-4)
    assert scene.surface[second.triangle[0]] == surface_number("brick")
    assert scene.blocked(origins, directions).tolist() == [True, False]


def test_no_rays_meet_nothing() -> None:
    nothing = np.zeros((0, 3), np.float32)
    assert sphere_scene().cast(nothing, nothing).distance_m.shape == (0,)
    assert sphere_scene().blocked(nothing, nothing).shape == (0,)
