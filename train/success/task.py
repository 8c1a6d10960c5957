"""The task of predicting success along a trajectory, from a labelled data set."""

from collections.abc import Sequence

from matplotlib.figure import Figure
from torch import Tensor

from navtool.base.note import Note
from navtool.datasets.store.reader import NavDataset
from navtool.train.config import TrainConfig
from navtool.train.source import NavSource
from navtool.train.success.figure import prediction_figure
from navtool.train.success.judge import SuccessJudge
from navtool.train.success.loss import masked_mse
from navtool.train.success.samples import Sample, SampleDataset, hold_rows, success_samples
from navtool.train.success.telling import telling_samples
from navtool.train.task import Loss, Picture, Remarks, Task

_UNSEEN = 0.5
"""From this share of empty trajectory images on a run says so."""


def success_loss(output: Tensor, batch: Sample) -> Loss:
    """The squared error over the known steps."""
    return Loss(masked_mse(output, batch.target, batch.known), int(batch.known.sum()))


def unseen_trajectories(samples: SampleDataset) -> Remarks:
    """How many trajectories of a moving robot lie outside the picture, and what to do where they are many."""
    share = samples.unseen_share()
    why = "they end before the ground that the camera sees begins"
    cure = "ingest at a lower fps, so that the steps reach further, or look at the camera's mounting"
    what = f"{share:.0%} of the trajectory images are empty: {why}; {cure}"
    return Remarks({"unseen_share": share}, (Note("samples.unseen-trajectories", what),) if share > _UNSEEN else ())


def _draw(samples: Sequence[Sample], output: Tensor, config: TrainConfig) -> Figure:
    probability = output.float().cpu().numpy()
    return prediction_figure(samples, probability, success_threshold=config.metrics.success_threshold)


SUCCESS: Task[NavSource, SampleDataset, Sample, Tensor] = Task(
    open=NavDataset,
    samples=success_samples,
    hold=hold_rows,
    loss=success_loss,
    judge=SuccessJudge,
    remarks=unseen_trajectories,
    picture=Picture(choose=telling_samples, draw=_draw),
)
"""Success at each step of the horizon, [B, T] in (0, 1)."""
