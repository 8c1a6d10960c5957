"""What ``navtool fit intensity_threshold`` is configured with."""

from dataclasses import dataclass, field, fields

from navtool.datasets.ingest.config import Merge
from navtool.datasets.robot.config import RobotConfig
from navtool.methods.intensity_map.fit_run import ThresholdRunConfig


@dataclass(kw_only=True, slots=True)
class IntensityThresholdJob(ThresholdRunConfig):
    """The settings of the fit, and how recordings are read; a data set was read at ingest."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    """The robot: a preset by name (``robot=husky``), or a file with ``--robot``."""
    merge: Merge = Merge.file
    """Whether all bags in a folder are one recording: file or folder, as for ingest."""

    def config(self) -> ThresholdRunConfig:
        """The settings of the fit alone."""
        return ThresholdRunConfig(**{entry.name: getattr(self, entry.name) for entry in fields(ThresholdRunConfig)})
