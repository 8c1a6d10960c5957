"""The cells that outlines touch, against dense points and laws."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.truth import Outline, truth_classes

GRID = GridConfig(cells=20, cell_m=0.5)
HERE = np.zeros(3)


def star(rng: np.random.Generator, corners: int) -> NDArray[np.float64]:
    """A polygon, seldom convex, that does not cross itself."""
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    reach = rng.uniform(0.3, 4.0, corners)
    return np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1) + rng.uniform(-4, 4, 2)


def inside(corners: NDArray[np.float64], x: float, y: float) -> bool:
    """Even-odd rule, a corner at a time."""
    odd = False
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            odd = not odd
    return odd


@given(st.integers(0, 10_000))
@settings(max_examples=25, deadline=None)
def test_a_touched_cell_holds_a_point_of_the_outline(seed: int) -> None:
    rng = np.random.default_rng(seed)
    corners = star(rng, int(rng.integers(3, 9)))
    touched = truth_classes([Outline(CellClass.solid, corners)], HERE, GRID) == CellClass.solid
    naive = np.zeros_like(touched)
    along = np.concatenate(
        [np.linspace(a, b, 4000) for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True)]
    )
    cell = np.floor(along / GRID.cell_m + GRID.cells / 2).astype(int)
    cell = cell[((cell >= 0) & (cell < GRID.cells)).all(axis=1)]
    naive[cell[:, 0], cell[:, 1]] = True
    middles = (np.arange(GRID.cells) + 0.5 - GRID.cells / 2) * GRID.cell_m
    for row, x in enumerate(middles):
        for column, y in enumerate(middles):
            naive[row, column] |= inside(corners, float(x), float(y))
    assert not (naive & ~touched).any()
    # points along edges miss cells whose corner alone is cut
    assert (touched & ~naive).sum() <= 1


def test_a_thin_pane_is_a_gapless_line_of_cells() -> None:
    for yaw in np.linspace(0.0, 3.0, 13):
        way = np.array([np.cos(yaw), np.sin(yaw)])
        aside = 0.006 * np.array([-way[1], way[0]])
        pane = Outline(
            CellClass.transparent, np.array([3 * way + aside, -3 * way + aside, -3 * way - aside, 3 * way - aside])
        )
        touched = truth_classes([pane], HERE, GRID) == CellClass.transparent
        along = np.linspace(-3, 3, 500)[:, None] * way
        cell = np.floor(along / GRID.cell_m + GRID.cells / 2).astype(int)
        assert touched[cell[:, 0], cell[:, 1]].all()
        assert touched.sum() <= 2 * len(np.unique(cell, axis=0)) + 4


@given(st.floats(-5, 5), st.floats(-5, 5), st.integers(-4, 4))
@settings(max_examples=25, deadline=None)
def test_outlines_stay_where_they_are_while_the_sensor_moves(x: float, y: float, quarters: int) -> None:
    rng = np.random.default_rng(3)
    outlines = [Outline(what, star(rng, 6)) for what in (CellClass.pliable, CellClass.solid)]
    yaw = quarters * np.pi / 2
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    moved = [Outline(one.what, one.corners_m @ turn.T + (x, y)) for one in outlines]
    there = truth_classes(moved, np.array([x, y, yaw]), GRID)
    # rounding may decide about a corner that lies on a border
    assert (there != truth_classes(outlines, HERE, GRID)).sum() <= 2


def test_order_and_direction_do_not_matter_and_solid_goes_first() -> None:
    square = np.array([[0.1, 0.1], [0.9, 0.1], [0.9, 0.9], [0.1, 0.9]])
    outlines = [Outline(what, square) for what in (CellClass.solid, CellClass.transparent, CellClass.pliable)]
    expected = truth_classes(outlines, HERE, GRID)
    assert set(expected[10:12, 10:12].ravel()) == {CellClass.solid}
    assert (expected > 0).sum() == 4
    assert (truth_classes(outlines[::-1], HERE, GRID) == expected).all()
    backwards = [Outline(one.what, one.corners_m[::-1]) for one in outlines]
    assert (truth_classes(backwards, HERE, GRID) == expected).all()
    weaker = truth_classes(outlines[1:], HERE, GRID)
    assert set(weaker[10:12, 10:12].ravel()) == {CellClass.transparent}


def test_what_lies_beyond_the_grid_leaves_it_free() -> None:
    far = Outline(CellClass.solid, np.array([[50.0, 0.0], [51.0, 0.0], [50.0, 1.0]]))
    assert not truth_classes([far], HERE, GRID).any()
    around = Outline(CellClass.solid, np.array([[-50.0, -50.0], [50.0, -50.0], [50.0, 50.0], [-50.0, 50.0]]))
    assert (truth_classes([around], HERE, GRID) == CellClass.solid).all()


@pytest.mark.parametrize(
    ("what", "corners"),
    [
        (CellClass.free, np.eye(3)[:, :2]),
        (CellClass.solid, np.zeros((2, 2))),
        (CellClass.solid, np.array([[0.0, 0.0], [np.nan, 0.0], [1.0, 1.0]])),
    ],
)
def test_what_is_no_outline_is_refused(what: CellClass, corners: NDArray[np.float64]) -> None:
    with pytest.raises(ValueError, match="outline"):
        Outline(what, corners)
