import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.legged.footings import Patch
from navtool.sim.legged.terrain import Terrain


def patch(heights: Array, **grip: float) -> Patch:
    hold = {"friction": 0.7, "stiffness_npm": 1e5, "damping_nspm": 100.0} | grip
    return Patch(origin_m=(-1.0, -2.0), cell_m=0.1, heights_m=heights, **hold)


def naive_height(heights: Array, x: float, y: float) -> float:
    across = min(max((x + 1.0) / 0.1, 0.0), heights.shape[1] - 1.0 - 1e-9)
    along = min(max((y + 2.0) / 0.1, 0.0), heights.shape[0] - 1.0 - 1e-9)
    i, j = int(across), int(along)
    u, v = across - i, along - j
    corner, right, up, far = heights[j, i], heights[j, i + 1], heights[j + 1, i], heights[j + 1, i + 1]
    if u >= v:
        return float(corner + u * (right - corner) + v * (far - right))
    return float(corner + v * (up - corner) + u * (far - up))


@settings(max_examples=30)
@given(st.integers(0, 1000), st.floats(-3, 3), st.floats(-4, 4))
def test_heights_lie_on_the_triangles_and_go_on_beyond_the_rim(seed: int, x: float, y: float) -> None:
    heights = np.random.default_rng(seed).normal(0.0, 1.0, (9, 13))
    found = Terrain(patch(heights)).height(np.array([[x, y]]))
    assert found[0] == pytest.approx(naive_height(heights, x, y), abs=1e-9)


@pytest.mark.parametrize(("slope_x", "slope_y"), [(0.0, 0.0), (0.3, 0.0), (-0.2, 0.5)])
def test_a_ball_on_a_slope_meets_the_slope(slope_x: float, slope_y: float) -> None:
    rows, columns = np.mgrid[:40, :30]
    terrain = Terrain(patch(slope_x * (columns * 0.1 - 1.0) + slope_y * (rows * 0.1 - 2.0)))
    centre = np.array([[0.31, -0.47, 0.6], [0.77, 0.11, -0.3]])
    point, normal, _ = terrain.contact(centre, np.array([0.03, 0.09]))
    expected = np.array([-slope_x, -slope_y, 1.0]) / np.sqrt(1 + slope_x**2 + slope_y**2)
    assert normal == pytest.approx(np.tile(expected, (2, 1)), abs=1e-9)
    on_the_plane = point[:, 2] - slope_x * point[:, 0] - slope_y * point[:, 1]
    assert on_the_plane == pytest.approx(np.zeros(2), abs=1e-9)


def test_a_ball_beside_a_step_meets_its_edge_before_the_floor() -> None:
    heights = np.zeros((20, 20))
    heights[:, 10:] = 0.15  # the flank runs from x = -0.1 to 0.0
    terrain = Terrain(patch(heights))
    near, far = np.array([[-0.11, -1.0, 0.03]]), np.array([[-0.2, -1.0, 0.03]])
    radius = np.array([0.03])
    assert terrain.contact(near, radius).normal[0, 0] < -0.5, "it is pushed back"
    assert terrain.contact(far, radius).normal[0] == pytest.approx([0.0, 0.0, 1.0])


def test_the_grip_is_that_of_the_place() -> None:
    hold = {
        "friction": 0.3,
        "stiffness_npm": 9.0,
        "damping_nspm": 8.0,
        "drag_nspm2": 7.0,
        "cover_m": 0.6,
        "stems_n": 5.0,
    }
    footing = patch(np.zeros((5, 5)), **hold)
    contact = Terrain(footing).contact(np.zeros((1, 3)), np.array([0.03]))
    assert contact.grip[0].tolist() == list(hold.values())


def test_grounds_that_nothing_can_stand_on_are_refused() -> None:
    with pytest.raises(SimError, match="at least 2 x 2"):
        Terrain(patch(np.zeros((1, 5))))
    with pytest.raises(SimError, match="1 of 9 heights"):
        Terrain(patch(np.where(np.eye(3) * [[1], [0], [0]], np.nan, 0.0)))
    with pytest.raises(SimError, match="friction"):
        Terrain(patch(np.zeros((3, 3)), friction=0.0))
    with pytest.raises(SimError, match="friction"):
        Terrain(patch(np.zeros((3, 3)), drag_nspm2=-1.0))
