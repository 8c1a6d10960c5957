"""How far a training run is, for who wants to know."""

from typing import Any

import lightning.pytorch as pl

from navtool.base.progress import Progress


class EpochProgress(pl.Callback):
    """Reports a run's epochs and its batches; those of validation are not counted."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._first = 0

    def on_train_start(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Begin with the epochs that are left."""
        del pl_module
        self._first = trainer.current_epoch
        epochs = (trainer.max_epochs or 0) - self._first
        self._progress.begin(epochs, epochs * int(trainer.num_training_batches))

    def on_train_batch_end(
        self, trainer: pl.Trainer, pl_module: pl.LightningModule, outputs: Any, batch: Any, batch_idx: int
    ) -> None:
        """Report a batch."""
        del trainer, pl_module, outputs, batch, batch_idx
        self._progress.advance(1, 0)

    def on_validation_end(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Report an epoch, with the loss that it ended with."""
        del pl_module
        loss = float(trainer.callback_metrics["val/loss"])
        self._progress.done(trainer.current_epoch - self._first + 1, f"validation loss {loss:.4g}")
