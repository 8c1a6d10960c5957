import numpy as np

from navtool.sim.world.mesh import join_meshes
from navtool.sim.world.primitives import box, tube
from navtool.sim.world.surfaces import surface_number


def test_the_normals_about_a_trunk_point_away_from_its_axis_and_what_is_not_round_has_none() -> None:
    block = box(1.0, 1.0, 1.0, 0.0, surface_number("concrete"))
    trunk = tube(np.array([[4.0, 0.0, -0.1], [4.0, 0.0, 4.0]]), np.full(2, 0.5), 9, surface_number("bark"))
    mesh = join_meshes([block, trunk])
    normals = mesh.vertex_normals(mesh.surface == surface_number("bark"))
    assert not normals[: len(block.vertices)].any()
    outward = trunk.vertices[:-1, :2] - np.array([4.0, 0.0])  # the last one is its tip
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    flat = normals[len(block.vertices) : -1, :2]
    assert ((flat * outward).sum(axis=1) > 0.9 * np.linalg.norm(flat, axis=1)).all()
