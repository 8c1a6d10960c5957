"""Counts against loops over cells, what is observed, and laws of scores."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from intensity_scene import Stand, scan_scene
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import GridConfig, LayerConfig
from navtool.pipeline.intensity_map.layer_points import LayerPoints, sort_points
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.score import (
    QUESTIONS,
    Counts,
    compare,
    no_counts,
    observed_cells,
    passed_over,
)

GRID = GridConfig(cells=16, cell_m=0.5)
SIDE = GRID.cells


def random_maps(seed: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.bool_]]:
    rng = np.random.default_rng(seed)
    sparse = [0.85, 0.05, 0.06, 0.04]
    classes, truth = (rng.choice(4, (SIDE, SIDE), p=sparse).astype(np.uint8) for _ in range(2))
    return classes, truth, rng.random((SIDE, SIDE)) < 0.6


def near(mask: NDArray[np.bool_], row: int, column: int) -> bool:
    return bool(mask[max(row - 1, 0) : row + 2, max(column - 1, 0) : column + 2].any())


def points_at(*ends: tuple[float, float]) -> LayerPoints:
    x, y = (np.array(column, np.float32) for column in zip(*ends, strict=True))
    row, column = (np.floor(part / GRID.cell_m + SIDE / 2).astype(np.int64) for part in (x, y))
    return LayerPoints(x, y, np.ones_like(x), row * SIDE + column)


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_counts_equal_a_loop_over_cells(seed: int) -> None:
    classes, truth, observed = random_maps(seed)
    counts = compare(classes, truth, observed)
    confusion = np.zeros((4, 4), np.int64)
    naive = np.zeros((4, len(QUESTIONS)), np.int64)
    for row in range(SIDE):
        for column in range(SIDE):
            if not observed[row, column]:
                continue
            confusion[truth[row, column], classes[row, column]] += 1
            for number, asked in enumerate(QUESTIONS.values()):
                if classes[row, column] in asked:
                    naive[0 if near(np.isin(truth, asked), row, column) else 1, number] += 1
                if truth[row, column] in asked:
                    naive[2 if near(np.isin(classes, asked), row, column) else 3, number] += 1
    assert (counts.confusion == confusion).all()
    assert (np.stack([counts.right, counts.wrong, counts.found, counts.missed]) == naive).all()


@given(st.integers(0, 10_000))
@settings(max_examples=20, deadline=None)
def test_the_tolerance_never_lowers_a_score_and_the_truth_scores_one(seed: int) -> None:
    classes, truth, observed = random_maps(seed)
    counts, perfect = compare(classes, truth, observed), compare(truth, truth, observed)
    for question in QUESTIONS:
        for tolerant, exact in zip(counts.score(question), counts.exact_score(question), strict=True):
            assert tolerant is not None
            assert exact is not None
            assert 0 <= exact <= tolerant <= 1
        assert perfect.score(question) == perfect.exact_score(question) == (1, 1, 1)


def test_a_wider_tolerance_forgives_more_and_none_is_exact() -> None:
    maps = random_maps(5)
    scores = [compare(*maps, tolerance_cells=reach).score("solid").f for reach in range(4)]
    assert scores[0] == compare(*maps).exact_score("solid").f
    assert scores == sorted(scores, key=lambda score: score or 0.0)
    assert scores[0] != scores[-1]


def test_counts_of_several_clouds_add_up() -> None:
    maps = [random_maps(seed) for seed in range(3)]
    total = sum((compare(*one) for one in maps), start=no_counts())
    size = 3 * (SIDE + 2)
    classes, truth = (np.zeros((size, size), np.uint8) for _ in range(2))
    observed = np.zeros((size, size), bool)
    for number, one in enumerate(maps):
        block = slice(number * (SIDE + 2) + 1, (number + 1) * (SIDE + 2) - 1)
        classes[block, block], truth[block, block], observed[block, block] = one
    side_by_side = compare(classes, truth, observed)
    assert (total.confusion == side_by_side.confusion).all()
    assert total.score("avoid") == side_by_side.score("avoid")


def test_a_pane_that_no_map_shows_is_missed() -> None:
    truth = np.zeros((SIDE, SIDE), np.uint8)
    truth[11] = CellClass.transparent
    truth[14] = CellClass.solid
    classes = np.where(truth == CellClass.solid, np.uint8(CellClass.solid), np.uint8(CellClass.free))
    # all that returns is the wall behind it
    wall = points_at(*((3.25, float(y)) for y in np.arange(-3.9, 4.0, 0.05)))
    observed = observed_cells(wall, GRID)
    counts = compare(classes, truth, observed)
    assert counts.score("transparent").recall == 0
    assert observed[11].sum() >= 8
    assert counts.score("avoid").recall == 16 / (16 + observed[11].sum())


def test_what_is_not_asked_about_has_no_score() -> None:
    nothing = no_counts().score("transparent")
    assert nothing == (None, None, None)
    classes, truth, observed = random_maps(0)
    wrong = compare(np.where(classes == 3, np.uint8(0), classes), truth, observed).score("transparent")
    assert wrong.precision is None
    assert wrong.recall == 0
    assert wrong.f is None


def test_what_lies_behind_the_nearest_return_is_seen_where_beams_end_alone() -> None:
    seen = observed_cells(points_at((1.3, 0.013), (3.3, 0.033)), GRID)
    assert np.flatnonzero(seen[:, 8]).tolist() == [8, 9, 10, 14]
    over = passed_over(points_at((1.3, 0.013), (3.3, 0.033)).cell, GRID)
    assert np.flatnonzero(over[:, 8]).tolist() == list(range(8, 15))
    assert not seen[:, :8].any()


def test_observed_cells_are_the_ends_and_what_is_before_them() -> None:
    xyz, intensity = scan_scene([Stand("wall", (3.0, -3.5), (3.0, 3.5)), Stand("grass", (-3.0, 1.0), (1.0, -3.0))])
    points = sort_points(xyz, intensity, GRID, LayerConfig(ground_margin_m=0.0))
    seen = observed_cells(points, GRID).reshape(-1)
    ends = np.unique(points.cell % (SIDE * SIDE))
    assert seen[ends].all()
    assert not (seen & ~passed_over(points.cell, GRID).reshape(-1))[np.setdiff1d(np.arange(seen.size), ends)].any()


def test_counts_are_summed_by_part() -> None:
    one = compare(*random_maps(1))
    assert isinstance(one + no_counts(), Counts)
    assert (one + no_counts()).score("solid") == one.score("solid")
