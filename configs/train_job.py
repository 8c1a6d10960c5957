"""What ``navtool train`` is configured with."""

from dataclasses import dataclass

from omegaconf import MISSING

from navtool.configs.settings_of import settings_of
from navtool.train.config import TrainConfig


@dataclass(kw_only=True, slots=True)
class TrainJob(TrainConfig):
    """The configuration of a run, and the data set that it trains on."""

    dataset: str = MISSING
    """Folder of the data set."""

    def config(self) -> TrainConfig:
        """The run's configuration alone."""
        return settings_of(self, TrainConfig)
