"""Lightning's trainer as a run uses it, with plain errors for what can go wrong."""

import signal
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import lightning.pytorch as pl
import torch
from lightning.pytorch.callbacks import LearningRateMonitor
from lightning.pytorch.loggers import TensorBoardLogger

from navtool.base.plain import flatten
from navtool.base.progress import Progress
from navtool.train.config import Precision, TrainConfig
from navtool.train.datamodule import RunData
from navtool.train.epoch_progress import EpochProgress
from navtool.train.errors import TrainError
from navtool.train.models import kind_of
from navtool.train.module import NetworkModule
from navtool.train.prediction_figure import PredictionFigure
from navtool.train.quiet import quiet_lightning
from navtool.train.run_folder import RunFolder
from navtool.train.splits import Split


def fit(
    config: TrainConfig,
    folder: RunFolder,
    module: NetworkModule,
    data: RunData,
    callbacks: Sequence[pl.Callback],
    *,
    device: torch.device,
    resume: bool,
    progress: Progress | None,
) -> None:
    """Train to the configured number of epochs, from the folder's last checkpoint where ``resume`` says so.

    Raises:
        TrainError: It was interrupted, ran out of memory, or diverged; whole epochs stay in the folder.
    """
    with quiet_lightning(), _plain_errors(folder):
        data.setup("fit")
        if config.trainer.channels_last:
            module.to(memory_format=torch.channels_last)
        logger = TensorBoardLogger(folder.path, name=folder.tensorboard.name, version="", default_hp_metric=False)
        logger.log_hyperparams(flatten(config))
        picture = kind_of(config.model).task.picture
        trainer = pl.Trainer(
            accelerator=device.type,
            devices=1,
            precision="bf16-mixed" if config.trainer.precision is Precision.bf16 else "32-true",
            max_epochs=config.trainer.epochs,
            gradient_clip_val=config.trainer.gradient_clip,
            logger=logger,
            callbacks=[
                *callbacks,
                LearningRateMonitor(logging_interval="epoch"),
                *([PredictionFigure(picture, data.samples[Split.val], config)] if picture is not None else []),
                *([EpochProgress(progress)] if progress is not None else []),
            ],
            enable_progress_bar=False,
            enable_model_summary=False,
            num_sanity_val_steps=0,
            use_distributed_sampler=False,
            default_root_dir=folder.path,
        )
        trainer.fit(module, datamodule=data, ckpt_path=folder.last if resume else None, weights_only=True)


@contextmanager
def _plain_errors(folder: RunFolder) -> Iterator[None]:
    """Turn an interruption and exhausted memory into our error, and leave Ctrl-C as it was."""
    main = threading.current_thread() is threading.main_thread()
    handler = signal.getsignal(signal.SIGINT) if main else None
    try:
        yield
    except (KeyboardInterrupt, SystemExit) as error:  # Lightning exits on Ctrl-C
        kept = "its whole epochs are kept" if folder.last.is_file() else "before its first epoch was complete"
        raise TrainError(f"interrupted; {kept}", where=folder.path, cure="resume the run") from error
    except torch.OutOfMemoryError as error:
        raise TrainError(
            "the device ran out of memory",
            where="trainer.batch_size",
            cure="lower trainer.batch_size or set precision=bf16",
        ) from error
    finally:
        if main and handler is not None:
            signal.signal(signal.SIGINT, handler)
