"""The samples of a data set as batches for training, validation and test."""

import lightning.pytorch as pl
import torch
from torch.utils.data import DataLoader, Dataset

from navtool.train.config import TrainConfig
from navtool.train.errors import TrainError
from navtool.train.row_cache import SampleCaches, fill_caches
from navtool.train.sampler import EpochSampler
from navtool.train.samples import Sample, SampleDataset
from navtool.train.source import NavSource
from navtool.train.splits import Split, Splits
from navtool.train.windows import WindowReport, Windows, plan_windows


class NavDataModule(pl.LightningDataModule):
    """Batches of a data set's splits.

    The order of training samples is a function of (seed, epoch). Validation and test come in the order of rows.
    """

    def __init__(self, source: NavSource, splits: Splits, config: TrainConfig, *, first_epoch: int = 0) -> None:
        """Plan the windows of each split.

        Args:
            source: The data set.
            splits: Its episodes by split.
            config: The run's configuration.
            first_epoch: Epoch that training begins with; above 0 where a run is resumed.

        Raises:
            TrainError: A split has no samples, or the images have another size than the network's.
        """
        super().__init__()
        self._source = source
        self._config = config
        self._first_epoch = first_epoch
        self.windows: dict[Split, Windows] = {
            split: plan_windows(source, splits.episodes(split), config.data)
            for split in (Split.train, Split.val, Split.test)
        }
        for split in (Split.train, Split.val, *([Split.test] if splits.test else [])):
            _check_samples(split, self.windows[split].report, least=2 if split is Split.train else 1)
        _check_image_size(source, splits.train[0], config)
        self._caches: SampleCaches | None = None

    @property
    def reports(self) -> dict[Split, WindowReport]:
        """What became of the rows of each split."""
        return {split: windows.report for split, windows in self.windows.items()}

    def setup(self, stage: str) -> None:
        """Read the frames and clouds that the caches hold."""
        if stage == "fit" and self._caches is None:
            rows = [*self.windows[Split.train].row.tolist(), *self.windows[Split.val].row.tolist()]
            self._caches = fill_caches(self._source, rows, self._config.data.cache_mib)

    def train_dataloader(self) -> DataLoader[Sample]:
        """Batches of the training samples in the epoch's order."""
        trainer = self._config.trainer
        dataset = self.samples(Split.train)
        sampler = EpochSampler(len(dataset), batch_size=trainer.batch_size, seed=self._config.seed)
        # The first batch is fetched before the trainer names the epoch.
        sampler.set_epoch(self._first_epoch)
        return self._loader(dataset, sampler)

    def val_dataloader(self) -> DataLoader[Sample]:
        """Batches of the validation samples."""
        return self._loader(self.samples(Split.val), None)

    def test_dataloader(self) -> DataLoader[Sample]:
        """Batches of the test samples."""
        return self._loader(self.samples(Split.test), None)

    def samples(self, split: Split) -> SampleDataset:
        """The samples of a split."""
        return SampleDataset(self._source, self.windows[split], self._config.data, self._caches)

    def _loader(self, dataset: SampleDataset, sampler: EpochSampler | None) -> DataLoader[Sample]:
        return sample_loader(dataset, self._config.trainer.batch_size, self._config.trainer.workers, sampler)


def sample_loader(
    dataset: Dataset[Sample], batch_size: int, workers: int, sampler: EpochSampler | None = None
) -> DataLoader[Sample]:
    """Batches of samples, in the order of rows where no sampler is given.

    Workers come from a fork server: video decoders and Arrow's threads do not survive a plain fork.
    """
    return DataLoader(
        dataset,
        batch_size=batch_size,
        sampler=sampler,
        num_workers=workers,
        persistent_workers=workers > 0,
        multiprocessing_context="forkserver" if workers else None,
        generator=torch.Generator(),  # else each iterator draws from the generator that dropout uses
    )


def _check_samples(split: Split, report: WindowReport, *, least: int) -> None:
    if report.samples >= least:
        return
    reasons = ", ".join(f"{count} {reason}" for reason, count in report.excluded.items() if count)
    cure = "run `navtool label` on the data set" if report.excluded["no_known_step"] else "record more"
    if report.excluded["no_image"] or report.excluded["no_cloud"]:
        cure = "data.missing_modality=blank trains on rows without camera or cloud"
    raise TrainError(
        f"the {split.value} split has {report.samples} samples of {report.rows} rows ({reasons or 'no rows'})",
        where=f"split.{split.value}",
        cure=cure,
    )


def _check_image_size(source: NavSource, episode: int, config: TrainConfig) -> None:
    camera = source.calibration(episode).camera
    wanted = (config.model.image_width, config.model.image_height)
    if camera is not None and (camera.width, camera.height) != wanted:
        raise TrainError(
            f"the data set's images are {camera.width}x{camera.height} pixels, the network's {wanted[0]}x{wanted[1]}",
            where="model.image_width",
            cure=f"set model.image_width={camera.width} and model.image_height={camera.height}",
        )
