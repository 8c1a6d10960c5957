"""How fast a run trains, and how long it waits for data."""

import time
from typing import Any

import lightning.pytorch as pl

from navtool.train.samples import Batch


class PerfMonitor(pl.Callback):
    """Logs ``perf/samples_per_s`` and ``perf/data_wait_s`` per epoch; validation and checkpoints do not count.

    The wait is the mean time of a step between the end of the step before it and its own start.
    """

    def __init__(self) -> None:
        self.samples = 0
        """Samples trained on in this process."""
        self.train_s = 0.0
        """Seconds from each epoch's start to the end of its last step, summed."""
        self.wait_s = 0.0
        """Seconds of that spent between steps."""
        self._epoch: list[float] = []
        self._mark = 0.0
        self._begin = 0.0
        self._epoch_samples = 0

    def on_train_epoch_start(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Start the epoch's clock."""
        del trainer, pl_module
        self._begin = self._mark = time.perf_counter()
        self._epoch, self._epoch_samples = [], 0

    def on_train_batch_start(
        self, trainer: pl.Trainer, pl_module: pl.LightningModule, batch: Any, batch_idx: int
    ) -> None:
        """Take the wait for this batch."""
        del trainer, pl_module, batch, batch_idx
        self._epoch.append(time.perf_counter() - self._mark)

    def on_train_batch_end(
        self, trainer: pl.Trainer, pl_module: pl.LightningModule, outputs: Any, batch: Batch, batch_idx: int
    ) -> None:
        """Mark the end of the step."""
        del trainer, pl_module, outputs, batch_idx
        self._epoch_samples += len(batch[0])
        self._mark = time.perf_counter()

    def on_train_epoch_end(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Log the epoch's figures."""
        del trainer
        seconds, wait_s = self._mark - self._begin, sum(self._epoch)
        self.samples += self._epoch_samples
        self.train_s += seconds
        self.wait_s += wait_s
        pl_module.log("perf/samples_per_s", self._epoch_samples / max(seconds, 1e-9))
        pl_module.log("perf/data_wait_s", wait_s / max(len(self._epoch), 1))
