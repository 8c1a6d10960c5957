"""The checkpoints of a run: the last epoch's and the best one's."""

import math
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import lightning.pytorch as pl
from lightning.pytorch.callbacks import Checkpoint


class RunCheckpoint(Checkpoint):
    """Writes ``last.ckpt`` after each epoch and ``best.ckpt`` where the validation loss is the smallest so far.

    Each file is replaced in one step: whenever the process ends, both hold a whole epoch.
    """

    def __init__(self, folder: Path, stamp: Mapping[str, object]) -> None:
        self._folder = folder
        self._stamp = dict(stamp)
        self.best_loss = math.inf
        """Smallest validation loss so far."""
        self.best_epoch = -1
        """Epoch of it, counted from 0."""

    def on_train_epoch_end(self, trainer: pl.Trainer, pl_module: pl.LightningModule) -> None:
        """Write the checkpoints of the epoch that has ended, validation included."""
        del pl_module
        loss = float(trainer.callback_metrics["val/loss"])
        improved = loss < self.best_loss
        if improved:
            self.best_loss, self.best_epoch = loss, trainer.current_epoch
        self._folder.mkdir(parents=True, exist_ok=True)
        partial = self._folder / "partial.ckpt"
        trainer.save_checkpoint(partial)
        if improved:
            _twin(partial, self._folder / "partial-best.ckpt").replace(self._folder / "best.ckpt")
        partial.replace(self._folder / "last.ckpt")

    def on_save_checkpoint(
        self, trainer: pl.Trainer, pl_module: pl.LightningModule, checkpoint: dict[str, Any]
    ) -> None:
        """Say in the file what it is a checkpoint of."""
        del trainer, pl_module
        checkpoint["navtool"] = self._stamp

    def state_dict(self) -> dict[str, Any]:
        """What a resumed run must know."""
        return {"best_loss": self.best_loss, "best_epoch": self.best_epoch}

    def load_state_dict(self, state_dict: dict[str, Any]) -> None:
        """Go on from a checkpoint."""
        self.best_loss, self.best_epoch = float(state_dict["best_loss"]), int(state_dict["best_epoch"])


def _twin(path: Path, twin: Path) -> Path:
    """A second name for a file that is never written to again; a copy where the file system has no hard links."""
    twin.unlink(missing_ok=True)
    try:
        twin.hardlink_to(path)
    except OSError:
        shutil.copyfile(path, twin)
    return twin
