"""The training step, the validation and the optimiser of a network."""

import lightning.pytorch as pl
import torch
from torch import Tensor, nn

from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.models import kind_of
from navtool.train.samples import Batch
from navtool.train.seeding import seed_torch


class NetworkModule(pl.LightningModule):
    """Trains a network on its task's loss, and has the task's judge look at each epoch.

    Random numbers within an epoch are a function of (seed, epoch): a run resumed at an epoch's start goes on as if it
    had never stopped. The metrics of an epoch do not depend on how its samples were batched.
    """

    def __init__(self, model: nn.Module, config: TrainConfig) -> None:
        super().__init__()
        self.model = model
        self._config = config
        self._kind = kind_of(config.model)
        self._judge = self._kind.task.judge(config)

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Adam with the configured step size and penalty."""
        settings = self._config.optimizer
        return torch.optim.Adam(self.parameters(), lr=settings.learning_rate, weight_decay=settings.weight_decay)

    def on_train_epoch_start(self) -> None:
        """Make the epoch's dropout a function of (seed, epoch)."""
        seed_torch(self._config.seed, 1 + self.current_epoch)

    def training_step(self, batch: Batch) -> Tensor:
        """The loss of a batch.

        Raises:
            TrainError: The loss is not finite.
        """
        loss, weight = self._kind.task.loss(self.model(*self._kind.inputs(batch)), batch)
        if not bool(torch.isfinite(loss)):
            raise TrainError(
                f"the loss is {loss.item()} in epoch {self.current_epoch}",
                where="train/loss",
                cure="lower optimizer.learning_rate or set trainer.gradient_clip=1",
            )
        self.log("train/loss", loss, on_step=False, on_epoch=True, batch_size=weight)
        return loss

    def on_validation_epoch_start(self) -> None:
        """Forget the epoch before."""
        self._judge = self._kind.task.judge(self._config)

    def validation_step(self, batch: Batch) -> None:
        """Show a batch to the judge."""
        self._judge.add(batch, self.model(*self._kind.inputs(batch)))

    def on_validation_epoch_end(self) -> None:
        """Log the loss and the task's figures; what the samples do not define is not logged."""
        judged = self._judge.result()
        self.log("val/loss", judged.loss)
        self.log_dict({f"val/{name}": value for name, value in judged.logged.items() if value is not None})
