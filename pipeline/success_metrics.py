"""How well predicted success probabilities agree with what happened: rates, ranking and calibration under a mask."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float, Shaped

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array


@dataclass(kw_only=True, slots=True)
class SuccessMetricsConfig:
    """Where a prediction counts as traversable, and how finely calibration is looked at."""

    success_threshold: float = 0.56
    """e_th in [0, 1] (GrASPE, Table V): predicted traversable at this probability or above."""

    calibration_bins: int = 10
    """Number of bins of equal width over [0, 1] for the expected calibration error, >= 1."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 1, "success_threshold", cure="the paper uses 0.56"),
            outside(self, 1, math.inf, "calibration_bins"),
        )


@dataclass(frozen=True, slots=True)
class BinaryMetrics:
    """Agreement of probabilities with 0/1 outcomes; the positive class is 1, "traversable", as in the paper's rates.

    A figure that its samples do not define is None, never 0: without negatives there is no false positive rate.
    """

    positives: int
    """Number of outcomes that are 1."""
    negatives: int
    """Number of outcomes that are 0."""
    fpr: float | None
    """Share of the actual negatives that were predicted traversable."""
    fnr: float | None
    """Share of the actual positives that were predicted non-traversable."""
    f1: float | None
    """Harmonic mean of precision and recall of the traversable class."""
    average_precision: float | None
    """Average precision of the traversable class; a constant predictor gets positives / (positives + negatives)."""
    average_precision_failure: float | None
    """Average precision of the failures, ranked by 1 - probability: they are rare, so chance level is low and the
    figure separates models where the other one is near 1 for all of them."""
    brier: float | None
    """Mean squared difference of probability and outcome."""
    ece: float | None
    """Expected calibration error: mean over the samples of |mean probability - share of positives| of their bin."""


@dataclass(frozen=True, slots=True)
class SuccessMetrics:
    """Metrics of success probability vectors along trajectories."""

    threshold: float
    """e_th that the rates, F1 included, were taken at."""
    unknown: int
    """Trajectories without any known step; they count nowhere."""
    trajectory: BinaryMetrics
    """Whole trajectories: the smallest probability over the known steps against the worst known outcome."""
    steps: BinaryMetrics
    """All known steps pooled."""
    per_step: tuple[BinaryMetrics, ...]
    """Known steps of each horizon step k = 0..T-1."""


def success_metrics(
    probability: Float[Array, "n horizon"],
    outcome: Shaped[Array, "n horizon"],
    known: Bool[Array, "n horizon"],
    config: SuccessMetricsConfig,
) -> SuccessMetrics:
    r"""Metrics over whole trajectories, over all steps and for each horizon step; unknown steps have no influence.

    As Algorithm 1 uses the prediction, a trajectory is predicted traversable iff

    .. math:: \min_{k \in \text{known}} \hat{E}_t[k] \geq e_{th}

    and it is a negative if any known step of :math:`E_t` is 0.

    Args:
        probability: E-hat in [0, 1].
        outcome: E, 1 = success and 0 = failure; any value where it is not known.
        known: False where a step is masked.
        config: Threshold and bins.

    Raises:
        ValueError: A known probability is outside [0, 1] or not finite, or a known outcome is neither 0 nor 1.

    Reference: GrASPE, Algorithm 1 (line 20) and section V-C.
    """
    _check(probability[known], outcome[known])
    p = np.where(known, probability, 1.0).astype(np.float64)  # 1 is neutral in a minimum
    e = np.where(known, outcome, 1) != 0
    judged = known.any(axis=1)
    per_step = tuple(binary_metrics(p[known[:, k], k], e[known[:, k], k], config) for k in range(probability.shape[1]))
    return SuccessMetrics(
        threshold=config.success_threshold,
        unknown=int((~judged).sum()),
        trajectory=binary_metrics(p[judged].min(axis=1, initial=1.0), e[judged].all(axis=1), config),
        steps=binary_metrics(p[known], e[known], config),
        per_step=per_step,
    )


def binary_metrics(
    probability: Float[Array, " n"], outcome: Bool[Array, " n"], config: SuccessMetricsConfig
) -> BinaryMetrics:
    """Metrics of n probabilities of the outcome True."""
    positives, negatives = int(outcome.sum()), int((~outcome).sum())
    predicted = probability >= config.success_threshold
    false_positives = int((predicted & ~outcome).sum())
    false_negatives = int((~predicted & outcome).sum())
    true_positives = positives - false_negatives
    return BinaryMetrics(
        positives=positives,
        negatives=negatives,
        fpr=_ratio(false_positives, negatives),
        fnr=_ratio(false_negatives, positives),
        f1=_ratio(2 * true_positives, 2 * true_positives + false_positives + false_negatives),
        average_precision=average_precision(probability, outcome),
        average_precision_failure=average_precision(1.0 - probability, ~outcome),
        brier=float(np.mean((probability - outcome) ** 2)) if outcome.size else None,
        ece=expected_calibration_error(probability, outcome, config.calibration_bins),
    )


def average_precision(score: Float[Array, " n"], positive: Bool[Array, " n"]) -> float | None:
    r"""Area under the precision-recall steps; None where no sample is positive.

    .. math:: AP = \sum_i (R_i - R_{i-1}) P_i

    over the distinct scores from high to low, so that the order of tied samples has no influence.
    """
    total = int(positive.sum())
    if total == 0:
        return None
    order = np.argsort(-score, kind="stable")
    hits = np.cumsum(positive[order])
    last_of_tie = np.append(np.diff(score[order]) != 0.0, True)
    hits, retrieved = hits[last_of_tie], np.flatnonzero(last_of_tie) + 1
    gained = np.diff(hits, prepend=0)
    return float(np.sum(gained / total * (hits / retrieved)))


def expected_calibration_error(probability: Float[Array, " n"], outcome: Bool[Array, " n"], bins: int) -> float | None:
    r"""Expected calibration error over bins of equal width, the last one closed; None without samples.

    .. math:: ECE = \sum_b \frac{n_b}{n} | \overline{p}_b - \overline{e}_b |
    """
    if outcome.size == 0:
        return None
    index = np.minimum((probability * bins).astype(np.int64), bins - 1)
    gap = np.bincount(index, weights=probability - outcome, minlength=bins)  # n_b (mean p - mean e)
    return float(np.abs(gap).sum() / outcome.size)


def _ratio(part: int, whole: int) -> float | None:
    return part / whole if whole else None


def _check(probability: Float[Array, " n"], outcome: Shaped[Array, " n"]) -> None:
    outside = ~((probability >= 0.0) & (probability <= 1.0))
    if outside.any():
        raise ValueError(
            f"{int(outside.sum())} of {probability.size} known probabilities are not in [0, 1], "
            f"such as {probability[outside][0]}; a model must end in a sigmoid"
        )
    strange = (outcome != 0) & (outcome != 1)
    if strange.any():
        raise ValueError(
            f"{int(strange.sum())} of {outcome.size} known outcomes are neither 0 nor 1, such as {outcome[strange][0]}"
        )
