"""TensorBoard's picture of predictions."""

from typing import Any

import lightning.pytorch as pl
import numpy as np
from lightning.pytorch.loggers import TensorBoardLogger

from navtool.train.config import TrainConfig
from navtool.train.models import kind_of
from navtool.train.module import NetworkModule
from navtool.train.predict import predict_samples
from navtool.train.samples import Batch, Samples
from navtool.train.task import Picture


class PredictionFigure[BatchT: Batch](pl.Callback):
    """Draws the same validation samples after epochs 1, 2, 4, 8, ... and the last: few pictures, however long a run."""

    def __init__(self, picture: Picture[Any, BatchT, Any], samples: Samples[BatchT], config: TrainConfig) -> None:
        self._kind = kind_of(config.model)
        count = config.trainer.figure_samples
        self._picture = picture
        self._samples = samples
        self._config = config
        self._chosen = np.unique(np.linspace(0, len(samples) - 1, count).round().astype(np.int64)).tolist()

    def on_validation_end(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Draw the epoch that was just validated, where it is one of those."""
        done = trainer.current_epoch + 1
        due = done & (done - 1) == 0 or done == trainer.max_epochs
        logger = trainer.logger
        if not (
            due and self._chosen and isinstance(logger, TensorBoardLogger) and isinstance(pl_module, NetworkModule)
        ):
            return
        samples = [self._samples[index] for index in self._chosen]
        output = predict_samples(self._kind, pl_module.model, samples, pl_module.device)
        figure = self._picture.draw(samples, output, self._config)
        logger.experiment.add_figure("val/predictions", figure, global_step=trainer.global_step)
