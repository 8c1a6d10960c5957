"""Clipping: the areas that are left, against areas worked by hand and against sampling."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.pipeline.geometry.clip_polygons import clip_to_disc, clip_to_half_space

Floats = NDArray[np.float64]
SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def moved(x: float, y: float) -> Floats:
    return np.asarray(SQUARE + np.array([x, y]))


def areas(polygons: Floats) -> Floats:
    """The shoelace formula."""
    after = np.roll(polygons, -1, axis=1)
    return np.asarray(np.abs((polygons[..., 0] * after[..., 1] - after[..., 0] * polygons[..., 1]).sum(axis=1)) / 2)


@settings(deadline=None)
@given(angle=st.floats(0, 6.28), offset=st.floats(-2, 2), scale=st.floats(0.1, 5))
def test_the_two_sides_of_a_line_make_the_whole(angle: float, offset: float, scale: float) -> None:
    normal, polygon = np.array([np.cos(angle), np.sin(angle)]), scale * SQUARE[None]
    here, kept_here = clip_to_half_space(polygon, normal, offset)
    there, kept_there = clip_to_half_space(polygon, -normal, -offset)
    assert areas(here).sum() + areas(there).sum() == pytest.approx(4 * scale**2)
    assert kept_here.any() or kept_there.any()
    assert (here @ normal >= offset - 1e-9).all()


def test_a_batch_is_cut_row_by_row() -> None:
    polygons = np.stack([SQUARE, moved(3, 0), moved(-3, 0), moved(0.5, 0)])
    cut, kept = clip_to_half_space(polygons, np.array([1.0, 0.0]), 0.0)
    np.testing.assert_array_equal(kept, [True, True, False, True])
    np.testing.assert_allclose(areas(cut), [2, 4, 3])


def test_depth_is_cut_in_three_dimensions() -> None:
    triangle = np.array([[[0.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]]])
    cut, _ = clip_to_half_space(triangle, np.array([0.0, 0.0, 1.0]), 0.5)
    assert cut[..., 2].min() == pytest.approx(0.5)
    assert {tuple(np.round(point, 9)) for point in cut[0]} >= {(0.75, 0.0, 0.5), (-0.75, 0.0, 0.5)}


def test_disc_keeps_what_is_inside_and_drops_what_is_outside() -> None:
    polygons = np.stack([SQUARE * 0.3, moved(9, 0), moved(0.9, 0.9)])
    cut, kept = clip_to_disc(polygons, 1.2)
    np.testing.assert_array_equal(kept, [True, False, True])
    assert areas(cut)[0] == pytest.approx(0.36)
    assert np.hypot(cut[..., 0], cut[..., 1]).max() <= 1.2 + 1e-9


@settings(deadline=None, max_examples=50)
@given(x=st.floats(-1.5, 1.5), y=st.floats(-1.5, 1.5), size=st.floats(0.2, 0.8))
def test_disc_cuts_along_the_arc(x: float, y: float, size: float) -> None:
    polygon = SQUARE * size + [x, y]
    step = np.linspace(-size, size, 401)[:-1] + size / 400
    sampled = (np.hypot(x + step[:, None], y + step) <= 1.0).mean() * (2 * size) ** 2
    cut, _ = clip_to_disc(polygon[None], 1.0)
    # Eight chords in a half circle lose 0.04, and add nothing.
    assert sampled - 0.05 <= areas(cut).sum() <= sampled + 0.01


def test_the_arc_goes_the_long_way_where_it_must() -> None:
    # All of the disc below y = 0.5, in either sense of the outline: the arc is 240 degrees long.
    below = np.array([[-5.0, 0.5], [-5.0, -5.0], [5.0, -5.0], [5.0, 0.5]])
    cut, kept = clip_to_disc(np.stack([below, below[::-1]]), 1.0)
    assert kept.all()
    exact = np.pi - (np.pi / 3 - np.sqrt(3) / 4)
    inscribed = 8 * np.sin(np.pi / 6) / 2 + np.sqrt(3) / 4  # eight chords of 30 degrees, and the triangle to the line
    np.testing.assert_allclose(areas(cut), inscribed, rtol=1e-9)
    assert inscribed > 0.96 * exact


def test_a_quarter_disc_is_nearly_whole() -> None:
    cut, _ = clip_to_disc(moved(1.0, 1.0)[None], 1.0)
    assert areas(cut)[0] == pytest.approx(np.pi / 4, rel=0.03)


def test_nothing_is_left_of_nothing() -> None:
    for cut, kept in (
        clip_to_half_space(SQUARE[None], np.array([1.0, 0.0]), 5.0),
        clip_to_disc(SQUARE[None] + 9.0, 1.0),
        clip_to_disc(np.zeros((0, 4, 2)), 1.0),
    ):
        assert len(cut) == 0
        assert not kept.any()
