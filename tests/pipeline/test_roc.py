"""Curves against scikit-learn's, and what a best threshold is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sklearn.metrics import roc_auc_score, roc_curve

from navtool.pipeline.roc import roc

figures = st.lists(st.integers(0, 12).map(lambda k: k / 12), min_size=1, max_size=30)


@given(figures, figures)
def test_it_equals_scikit_learns(positives: list[float], negatives: list[float]) -> None:
    curve = roc(np.array(positives), np.array(negatives))
    truth = [1] * len(positives) + [0] * len(negatives)
    false, true, threshold = roc_curve(truth, [*positives, *negatives], drop_intermediate=False)
    np.testing.assert_allclose(curve.true_positive_rate, true)
    np.testing.assert_allclose(curve.false_positive_rate, false)
    # theirs is the figure itself, ours lies below it and above the next
    assert (curve.threshold[1:] < threshold[1:]).all()
    assert (curve.threshold[1:-1] > threshold[2:]).all()
    assert curve.area == pytest.approx(roc_auc_score(truth, [*positives, *negatives]))


@given(figures, figures)
def test_no_threshold_tells_them_apart_better_than_the_best(positives: list[float], negatives: list[float]) -> None:
    one, other = np.array(positives), np.array(negatives)
    best = roc(one, other).best()
    assert best.true_positive_rate == np.mean(one > best.threshold)
    assert best.false_positive_rate == np.mean(other > best.threshold)
    for threshold in np.arange(-1, 14) / 12:
        gain = np.mean(one > threshold) - np.mean(other > threshold)
        assert gain <= best.true_positive_rate - best.false_positive_rate + 1e-9


def test_kinds_that_lie_apart_have_a_threshold_between_them() -> None:
    curve = roc(np.array([0.7, 0.8, 0.9]), np.array([0.1, 0.3]))
    assert curve.area == 1.0
    assert list(curve.best()) == pytest.approx([0.5, 1.0, 0.0])


@pytest.mark.parametrize(
    ("positives", "negatives", "told"),
    [([], [0.1], "0 positives and 1 negatives"), ([0.1], [], "needs both"), ([np.nan], [0.1], "finite")],
)
def test_what_has_no_curve(positives: list[float], negatives: list[float], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        roc(np.array(positives), np.array(negatives))
