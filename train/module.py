"""The training step, the validation and the optimiser of a success predictor."""

import lightning.pytorch as pl
import torch
from torch import Tensor, nn

from navtool.pipeline.success_metrics import success_metrics
from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.loss import masked_mse
from navtool.train.predictions import PredictionLog, Predictions
from navtool.train.samples import Sample
from navtool.train.seeding import seed_torch


class SuccessModule(pl.LightningModule):
    """Trains a network on the masked squared error and judges it as the planner uses it.

    Random numbers within an epoch are a function of (seed, epoch): a run resumed at an epoch's start goes on as if it
    had never stopped. The metrics of an epoch do not depend on how its samples were batched.
    """

    def __init__(self, model: nn.Module, config: TrainConfig) -> None:
        super().__init__()
        self.model = model
        self._config = config
        self._log = PredictionLog()
        self.validation: Predictions | None = None
        """What the network said in the last validation; None before it."""

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Adam with the configured step size and penalty."""
        settings = self._config.optimizer
        return torch.optim.Adam(self.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay)

    def on_train_epoch_start(self) -> None:
        """Make the epoch's dropout a function of (seed, epoch)."""
        seed_torch(self._config.seed, 1 + self.current_epoch)

    def training_step(self, batch: Sample) -> Tensor:
        """The loss of a batch.

        Raises:
            TrainError: The loss is not finite.
        """
        loss = masked_mse(self.model(*batch.inputs()), batch.target, batch.known)
        if not bool(torch.isfinite(loss)):
            raise TrainError(
                f"the loss is {loss.item()} in epoch {self.current_epoch}",
                where="train/loss",
                cure="lower optimizer.learning_rate or set trainer.gradient_clip=1",
            )
        self.log("train/loss", loss, on_step=False, on_epoch=True, batch_size=int(batch.known.sum()))
        return loss

    def on_validation_epoch_start(self) -> None:
        """Forget the predictions of the epoch before."""
        self._log = PredictionLog()

    def validation_step(self, batch: Sample) -> None:
        """Predict a batch."""
        self._log.add(batch, self.model(*batch.inputs()))

    def on_validation_epoch_end(self) -> None:
        """Log the loss and the trajectory-wise figures; what the samples do not define is not logged."""
        self.validation = self._log.predictions()
        judged = success_metrics(
            self.validation.probability, self.validation.target, self.validation.known, self._config.metrics
        ).trajectory
        figures = {
            "val/loss": self.validation.loss(),
            "val/ap": judged.average_precision,
            "val/ap_failure": judged.average_precision_failure,
            "val/fpr": judged.fpr,
            "val/fnr": judged.fnr,
        }
        self.log_dict({name: value for name, value in figures.items() if value is not None})
