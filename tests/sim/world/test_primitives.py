import numpy as np
import pytest

from navtool.sim.world.mesh import TriangleMesh, join_meshes
from navtool.sim.world.primitives import box, sphere_points, tube
from navtool.sim.world.structures import make_rock


def volume(mesh: TriangleMesh) -> float:
    """By Gauss's theorem: right only for a closed mesh whose triangles look outwards."""
    a, b, c = (mesh.vertices[mesh.triangles[:, corner]].astype(np.float64) for corner in range(3))
    return float(np.einsum("ij,ij->", np.cross(a, b), c) / 6)


def test_a_box_encloses_its_volume() -> None:
    assert volume(box(1.5, 0.5, 2.0, 0.7, 0)) == pytest.approx(3.0 * 1.0 * 2.0, rel=1e-5)


def test_a_sphere_is_round_and_looks_outwards() -> None:
    vertices, triangles = sphere_points(3)
    assert np.linalg.norm(vertices, axis=1) == pytest.approx(np.ones(len(vertices)))
    mesh = TriangleMesh(vertices.astype(np.float32), triangles.astype(np.int32), np.zeros(len(triangles), np.uint8))
    assert len(triangles) == 20 * 4**3
    assert volume(mesh) == pytest.approx(4 / 3 * np.pi, rel=0.02)
    assert mesh.areas().sum() == pytest.approx(4 * np.pi, rel=0.02)


def test_a_tube_has_its_radius_and_looks_outwards() -> None:
    path = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 1.0], [0.3, 0.2, 2.0]])
    mesh = tube(path, np.array([0.2, 0.2, 0.1]), 12, 3)
    side = mesh.triangles[: 2 * 2 * 12]
    middle = mesh.vertices[side].mean(axis=1)
    axis = np.stack([np.interp(middle[:, 2], path[:, 2], path[:, k]) for k in range(3)], axis=1)
    outward = np.einsum("ij,ij->i", mesh.normals()[: len(side)], middle - axis)
    assert (outward > 0.05).all()
    assert (mesh.surface == 3).all()


def test_joining_keeps_every_triangle() -> None:
    parts = [box(1.0, 1.0, 1.0, 0.0, 1), box(0.5, 0.5, 1.0, 0.3, 2).moved(4.0, 0.0, 0.0)]
    joined = join_meshes(parts)
    corners = np.concatenate([part.vertices[part.triangles] for part in parts])
    assert (joined.vertices[joined.triangles] == corners).all()
    assert join_meshes([]).triangles.shape == (0, 3)


def test_rocks_are_lumps_of_their_size() -> None:
    for seed in range(5):
        rock = make_rock(0.5, np.random.default_rng(seed))
        reach = np.hypot(rock.vertices[:, 0], rock.vertices[:, 1]).max()
        assert 0.25 < reach < 0.46
        assert volume(rock) > 0.25 * reach**3
