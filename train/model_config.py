"""The settings of a network."""

from dataclasses import dataclass
from pathlib import Path

from navtool.base.setting_error import Fault
from navtool.train.success.windows import DataConfig


@dataclass(kw_only=True, slots=True)
class ModelConfig:
    """The settings of a network; each kind of model has a class of its own, and is known by it."""

    def faults(self, data: DataConfig) -> list[Fault]:
        """What in these settings does not fit those of the samples."""
        del data
        return []

    def files(self) -> tuple[Path, ...]:
        """The files that a run reads because of them."""
        return ()
