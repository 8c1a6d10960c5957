"""The samples of a run as batches for training, validation and test."""

from typing import Any

import lightning.pytorch as pl
import torch
from torch.utils.data import DataLoader, Dataset

from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.models import kind_of
from navtool.train.sampler import EpochSampler
from navtool.train.samples import Batch, SampleReport, Samples
from navtool.train.source import Source
from navtool.train.splits import Split, Splits

_PARTS = (Split.train, Split.val, Split.test)


class RunData(pl.LightningDataModule):
    """Batches of the splits.

    The order of training samples is a function of (seed, epoch). Validation and test come in the order of rows.
    """

    def __init__(self, source: Source, splits: Splits, config: TrainConfig, *, first_epoch: int = 0) -> None:
        """Plan the samples of each split.

        Args:
            source: The data.
            splits: Their episodes by split.
            config: The run's configuration.
            first_epoch: Epoch that training begins with; above 0 where a run is resumed.

        Raises:
            TrainError: A split has no samples, or the data do not suit the network.
        """
        super().__init__()
        kind = kind_of(config.model)
        self._task = kind.task
        self._config = config
        self._first_epoch = first_epoch
        self._held = False
        self.samples: dict[Split, Samples[Any]] = {
            split: self._task.samples(source, splits.episodes(split), config) for split in _PARTS
        }
        """The samples of each split."""
        for split in (Split.train, Split.val, *([Split.test] if splits.test else [])):
            _check_samples(split, self.samples[split].report, least=2 if split is Split.train else 1)
        if kind.check_source is not None:
            kind.check_source(source, splits.train[0], config.model)

    @property
    def reports(self) -> dict[Split, SampleReport]:
        """What became of the rows of each split."""
        return {split: samples.report for split, samples in self.samples.items()}

    def setup(self, stage: str) -> None:
        """Read what training holds in memory."""
        if stage == "fit" and self._task.hold is not None and not self._held:
            self._task.hold([self.samples[Split.train], self.samples[Split.val]], self._config)
            self._held = True

    def train_dataloader(self) -> DataLoader[Batch]:
        """Batches of the training samples in the epoch's order."""
        trainer, samples = self._config.trainer, self.samples[Split.train]
        sampler = EpochSampler(len(samples), batch_size=trainer.batch_size, seed=self._config.seed)
        # The first batch is fetched before the trainer names the epoch.
        sampler.set_epoch(self._first_epoch)
        return sample_loader(samples, trainer.batch_size, trainer.workers, sampler)

    def val_dataloader(self) -> DataLoader[Batch]:
        """Batches of the validation samples."""
        return self._in_order(Split.val)

    def test_dataloader(self) -> DataLoader[Batch]:
        """Batches of the test samples."""
        return self._in_order(Split.test)

    def _in_order(self, split: Split) -> DataLoader[Batch]:
        return sample_loader(self.samples[split], self._config.trainer.batch_size, self._config.trainer.workers)


def sample_loader[BatchT: Batch](
    samples: Dataset[BatchT], batch_size: int, workers: int, sampler: EpochSampler | None = None
) -> DataLoader[BatchT]:
    """Batches of samples, in the order of rows where no sampler is given.

    Workers come from a fork server: video decoders and Arrow's threads do not survive a plain fork.
    """
    return DataLoader(
        samples,
        batch_size=batch_size,
        sampler=sampler,
        num_workers=workers,
        persistent_workers=workers > 0,
        multiprocessing_context="forkserver" if workers else None,
        generator=torch.Generator(),  # else each iterator draws from the generator that dropout uses
    )


def _check_samples(split: Split, report: SampleReport, *, least: int) -> None:
    if report.samples >= least:
        return
    raise TrainError(
        f"the {split.value} split has {report.samples} samples of {report.rows} rows ({report.reasons() or 'no rows'})",
        where=f"split.{split.value}",
        cure=report.cure(),
    )
