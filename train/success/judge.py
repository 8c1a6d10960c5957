"""Judging success probabilities as the planner uses them."""

from collections.abc import Iterator
from dataclasses import fields

from torch import Tensor

from navtool.base.note import Note
from navtool.pipeline.success_metrics import BinaryMetrics, SuccessMetrics, success_metrics
from navtool.train.config import TrainConfig
from navtool.train.judgement import Judgement, Table
from navtool.train.success.predictions import PredictionLog
from navtool.train.success.samples import Sample

_FIGURES = tuple(entry.name for entry in fields(BinaryMetrics))


class SuccessJudge:
    """The masked squared error and `SuccessMetrics` of all samples; its output is [B, T]."""

    def __init__(self, config: TrainConfig) -> None:
        self._config = config.metrics
        self._log = PredictionLog()

    def add(self, batch: Sample, output: Tensor) -> None:
        """Take the probabilities of a batch."""
        self._log.add(batch, output)

    def result(self) -> Judgement:
        """The loss, and the metrics of trajectories, of steps and per horizon step; trajectories' are logged."""
        seen = self._log.predictions()
        metrics = success_metrics(seen.probability, seen.target, seen.known, self._config)
        whole = metrics.trajectory
        logged = {
            "ap": whole.average_precision,
            "ap_failure": whole.average_precision_failure,
            "fpr": whole.fpr,
            "fnr": whole.fnr,
        }
        return Judgement(seen.loss(), metrics, logged, _table(metrics), tuple(_doubts(metrics)))


def _doubts(metrics: SuccessMetrics) -> Iterator[Note]:
    """What speaks against relying on the figures, or on the network."""
    whole = metrics.trajectory
    counts = f"{whole.positives} successes, {whole.negatives} failures"
    if not whole.positives or not whole.negatives:
        kind = "failures" if whole.positives else "successes"
        what = f"the samples hold no {kind} ({counts}): no figure says whether the model tells them apart"
        yield Note("judged.one-class", what)
    elif whole.fpr == 1.0 and whole.fnr == 0.0:
        what = f"the model says success of every trajectory ({counts}): it warns of nothing"
        yield Note("judged.always-success", what)
    elif whole.fpr == 0.0 and whole.fnr == 1.0:
        what = f"the model says failure of every trajectory ({counts}): nothing is let pass"
        yield Note("judged.always-failure", what)


def _table(metrics: SuccessMetrics) -> Table:
    columns = ("trajectory", "all steps", *(f"t+{step}" for step in range(len(metrics.per_step))))
    judged = (metrics.trajectory, metrics.steps, *metrics.per_step)
    rows = [(name, *(getattr(part, name) for part in judged)) for name in _FIGURES]
    return Table("Success prediction", columns, rows)
