"""TensorBoard's picture of predictions."""

import lightning.pytorch as pl
import numpy as np
from lightning.pytorch.loggers import TensorBoardLogger

from navtool.train.figure import prediction_figure
from navtool.train.module import SuccessModule
from navtool.train.samples import SampleDataset


class PredictionFigure(pl.Callback):
    """Draws the same validation samples after epochs 1, 2, 4, 8, ... and the last: few pictures, however long a run."""

    def __init__(self, dataset: SampleDataset, count: int, success_threshold: float) -> None:
        self._dataset = dataset
        self._chosen = np.unique(np.linspace(0, len(dataset) - 1, count).round().astype(np.int64)).tolist()
        self._success_threshold = success_threshold

    def on_validation_end(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Draw the epoch that was just validated, where it is one of those."""
        done = trainer.current_epoch + 1
        due = done & (done - 1) == 0 or done == trainer.max_epochs
        logger = trainer.logger
        if not (
            due and self._chosen and isinstance(logger, TensorBoardLogger) and isinstance(pl_module, SuccessModule)
        ):
            return
        if pl_module.validation is None:
            return
        figure = prediction_figure(
            [self._dataset[index] for index in self._chosen],
            pl_module.validation.probability[self._chosen],
            success_threshold=self._success_threshold,
        )
        logger.experiment.add_figure("val/predictions", figure, global_step=trainer.global_step)
