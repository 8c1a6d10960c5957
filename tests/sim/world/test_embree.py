import subprocess
import sys

import numpy as np
import pytest
from embreex.mesh_construction import TriangleMesh as OneRayMesh
from embreex.rtcore_scene import EmbreeScene

from navtool.pipeline.arrays import Array
from navtool.sim.world.embree import EmbreeTree


def soup(count: int) -> tuple[Array, Array]:
    """Vertices and triangles of small triangles all about the origin."""
    rng = np.random.default_rng(3)
    corners = rng.uniform(-5, 5, (count, 1, 3)) + rng.normal(0.0, 0.3, (count, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * count, dtype=np.int32).reshape(-1, 3)


def rays(count: int, *, spread: float) -> tuple[Array, Array]:
    rng = np.random.default_rng(count)
    directions = np.array([1.0, 0.2, -0.1]) + rng.normal(0.0, spread, (count, 3))
    return rng.normal(0.0, 0.1, (count, 3)).astype(np.float32), directions.astype(np.float32)


@pytest.mark.parametrize("spread", [0.05, 2.0])
@pytest.mark.parametrize("count", [1, 15, 16, 17, 4096, 5000])
def test_packets_meet_what_single_rays_meet(count: int, spread: float) -> None:
    vertices, triangles = soup(3000)
    scene = EmbreeScene()
    mesh = OneRayMesh(scene, vertices, triangles)
    origins, directions = rays(count, spread=spread)
    alone = scene.run(origins, directions, output=True)
    tree = EmbreeTree(vertices, triangles)
    found = tree.first_met(origins, directions)
    assert mesh is not None
    assert (found.triangle == alone["primID"]).mean() > 0.999, "but for rays along the edge of two"
    same = (found.triangle == alone["primID"]) & (found.triangle >= 0)
    if count > 1000:
        assert 0.2 < same.mean() < 1, "some rays meet something, some do not"
    for ours, theirs in ((found.distance, "tfar"), (found.u, "u"), (found.v, "v")):
        assert ours[same] == pytest.approx(alone[theirs][same], abs=1e-4)
    for coherent in (True, False):
        assert (tree.blocked(origins, directions, coherent=coherent) == (found.triangle >= 0)).mean() > 0.999


def test_equal_rays_get_equal_answers_whatever_was_asked_before() -> None:
    tree = EmbreeTree(*soup(500))
    first = tree.first_met(*rays(100, spread=1.0))
    tree.first_met(*rays(5000, spread=2.0))
    again = tree.first_met(*rays(100, spread=1.0))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(first, again, strict=True))


_IDLE = """
import time
import numpy as np
from navtool.sim.world.embree import EmbreeTree

corners = np.random.default_rng(3).uniform(-5, 5, (6000, 3)).astype(np.float32)
triangles = np.arange(6000, dtype=np.int32).reshape(-1, 3)
kept = [EmbreeTree(corners, triangles), EmbreeTree(corners, triangles)]
EmbreeTree(corners, triangles)
kept.append(EmbreeTree(corners, triangles))
before_s = time.process_time()
time.sleep(0.3)
print(time.process_time() - before_s)
"""


def test_trees_that_are_not_asked_take_no_time() -> None:
    """A second device of Embree's would keep a core busy; in a process of its own, since tests make some of theirs."""
    idle = subprocess.run([sys.executable, "-c", _IDLE], capture_output=True, text=True, check=True)  # noqa: S603
    assert float(idle.stdout) < 0.1
