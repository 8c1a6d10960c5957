"""Rates, ranking and calibration against naive loops and scikit-learn."""

from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from sklearn.metrics import average_precision_score, brier_score_loss, f1_score

from navtool.base.setting_error import SettingError
from navtool.pipeline.success_metrics import (
    SuccessMetricsConfig,
    average_precision,
    binary_metrics,
    expected_calibration_error,
    success_metrics,
)

CONFIG = SuccessMetricsConfig()
seeds = st.integers(0, 2**32 - 1)


def draw(seed: int, n: int = 60, horizon: int = 4) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.bool_]]:
    """Probabilities on a coarse grid (so that ties occur), outcomes and a mask."""
    rng = np.random.default_rng(seed)
    probability = rng.integers(0, 21, (n, horizon)) / 20.0
    outcome = (rng.random((n, horizon)) < 0.8).astype(np.int64)
    return probability, outcome, rng.random((n, horizon)) < 0.7


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_trajectory_rates_equal_a_naive_loop(seed: int) -> None:
    probability, outcome, known = draw(seed)
    false_positives = false_negatives = positives = negatives = unknown = 0
    for p, e, k in zip(probability, outcome, known, strict=True):
        steps = [i for i in range(len(k)) if k[i]]
        if not steps:
            unknown += 1
            continue
        traversable = min(p[i] for i in steps) >= 0.56
        failed = any(e[i] == 0 for i in steps)
        negatives += failed
        positives += not failed
        false_positives += failed and traversable
        false_negatives += not failed and not traversable
    got = success_metrics(probability, outcome, known, CONFIG)
    assert (got.unknown, got.trajectory.positives, got.trajectory.negatives) == (unknown, positives, negatives)
    assert got.trajectory.fpr == (false_positives / negatives if negatives else None)
    assert got.trajectory.fnr == (false_negatives / positives if positives else None)


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_unknown_steps_have_no_influence(seed: int) -> None:
    probability, outcome, known = draw(seed)
    other_probability = np.where(known, probability, np.nan)
    other_outcome = np.where(known, outcome, -7)
    assert success_metrics(probability, outcome, known, CONFIG) == success_metrics(
        other_probability, other_outcome, known, CONFIG
    )


@given(seeds)
@settings(max_examples=40, deadline=None)
def test_binary_metrics_equal_scikit_learn(seed: int) -> None:
    probability, outcome, _ = draw(seed, n=40, horizon=1)
    p, e = probability[:, 0], outcome[:, 0] == 1
    e[0], e[1] = True, False
    got = binary_metrics(p, e, CONFIG)
    assert got.average_precision == pytest.approx(average_precision_score(e, p), abs=1e-12)
    assert got.average_precision_failure == pytest.approx(average_precision_score(~e, 1.0 - p), abs=1e-12)
    assert got.brier == pytest.approx(brier_score_loss(e, p), abs=1e-12)
    assert got.f1 == pytest.approx(f1_score(e, p >= 0.56), abs=1e-12)


@given(seeds, st.integers(1, 12))
@settings(max_examples=40, deadline=None)
def test_calibration_error_equals_a_naive_loop(seed: int, bins: int) -> None:
    rng = np.random.default_rng(seed)
    p = np.concatenate([rng.random(50), [0.0, 1.0]])
    e = rng.random(52) < 0.6
    expected = 0.0
    for b in range(bins):
        members = [i for i in range(52) if min(int(p[i] * bins), bins - 1) == b]
        if members:
            expected += len(members) / 52 * abs(float(np.mean(p[members])) - float(np.mean(e[members])))
    assert expected_calibration_error(p, e, bins) == pytest.approx(expected, abs=1e-12)


@given(seeds)
@settings(max_examples=25, deadline=None)
def test_order_and_ties_have_no_influence(seed: int) -> None:
    probability, outcome, known = draw(seed)
    order = np.random.default_rng(seed).permutation(len(probability))
    before = success_metrics(probability, outcome, known, CONFIG)
    after = success_metrics(probability[order], outcome[order], known[order], CONFIG)
    assert astuple(before.trajectory) == pytest.approx(astuple(after.trajectory), abs=1e-12)
    assert [step.average_precision for step in before.per_step] == pytest.approx(
        [step.average_precision for step in after.per_step], abs=1e-12
    )


@given(seeds, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
@settings(max_examples=40, deadline=None)
def test_a_higher_threshold_trades_false_positives_for_false_negatives(seed: int, a: float, b: float) -> None:
    low, high = sorted((a, b))
    arrays = draw(seed)
    lenient = success_metrics(*arrays, SuccessMetricsConfig(success_threshold=low)).steps
    strict = success_metrics(*arrays, SuccessMetricsConfig(success_threshold=high)).steps
    assert strict.fpr is not None
    assert lenient.fpr is not None
    assert strict.fpr <= lenient.fpr
    assert strict.fnr is not None
    assert lenient.fnr is not None
    assert strict.fnr >= lenient.fnr


def test_per_step_counts_add_up_to_the_pooled_ones() -> None:
    probability, outcome, known = draw(3)
    got = success_metrics(probability, outcome, known, CONFIG)
    assert sum(step.positives for step in got.per_step) == got.steps.positives
    assert sum(step.negatives for step in got.per_step) == got.steps.negatives
    assert got.steps.positives + got.steps.negatives == known.sum()


def test_the_threshold_itself_is_traversable() -> None:
    p = np.array([0.56, np.float64(np.nextafter(0.56, 0.0))])
    got = binary_metrics(p, np.array([False, False]), CONFIG)
    assert got.fpr == 0.5


def test_what_is_undefined_is_none_and_the_count_says_why() -> None:
    p = np.full((3, 2), 0.9)
    known = np.ones((3, 2), dtype=np.bool_)
    only_success = success_metrics(p, np.ones((3, 2), dtype=np.int64), known, CONFIG).trajectory
    assert (only_success.negatives, only_success.fpr, only_success.average_precision_failure) == (0, None, None)
    assert (only_success.fnr, only_success.average_precision) == (0.0, 1.0)
    only_failure = success_metrics(p, np.zeros((3, 2), dtype=np.int64), known, CONFIG).trajectory
    assert (only_failure.positives, only_failure.fnr, only_failure.average_precision) == (0, None, None)
    assert only_failure.fpr == 1.0
    nothing = success_metrics(p, np.ones((3, 2), dtype=np.int64), ~known, CONFIG)
    assert nothing.unknown == 3
    assert astuple(nothing.trajectory) == (0, 0, None, None, None, None, None, None, None)
    assert nothing.steps == nothing.trajectory


def test_no_samples_at_all() -> None:
    got = success_metrics(np.empty((0, 2)), np.empty((0, 2), dtype=np.int64), np.empty((0, 2), dtype=np.bool_), CONFIG)
    assert got.trajectory.positives == 0
    assert got.trajectory.brier is None
    assert len(got.per_step) == 2


def test_a_perfect_ranking_has_average_precision_one() -> None:
    positive = np.array([False, True, False, True])
    assert average_precision(np.array([0.1, 0.8, 0.2, 0.9]), positive) == 1.0
    assert average_precision(np.full(4, 0.5), positive) == 0.5  # a constant gets the share of positives


@pytest.mark.parametrize(("value", "message"), [(np.nan, "not in"), (1.5, "1.5"), (-0.1, "-0.1")])
def test_a_known_probability_outside_the_unit_interval_is_refused(value: float, message: str) -> None:
    p = np.array([[0.5, value]])
    with pytest.raises(ValueError, match=message):
        success_metrics(p, np.ones((1, 2), dtype=np.int64), np.ones((1, 2), dtype=np.bool_), CONFIG)


def test_a_known_outcome_that_is_not_binary_is_refused() -> None:
    with pytest.raises(ValueError, match="neither 0 nor 1"):
        success_metrics(np.full((1, 2), 0.5), np.array([[0, 2]]), np.ones((1, 2), dtype=np.bool_), CONFIG)


@pytest.mark.parametrize("settings_", [{"success_threshold": 1.2}, {"calibration_bins": 0}])
def test_impossible_settings_are_refused(settings_: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=next(iter(settings_))):
        SuccessMetricsConfig(**settings_)  # type: ignore[arg-type]  # the point of the test
