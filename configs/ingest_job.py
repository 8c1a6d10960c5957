"""What ``navtool ingest`` is configured with."""

from dataclasses import dataclass, field

from navtool.configs.settings_of import settings_of
from navtool.datasets.ingest.config import IngestConfig
from navtool.datasets.robot.config import RobotConfig


@dataclass(kw_only=True, slots=True)
class IngestJob(IngestConfig):
    """The settings of ingest, and a robot."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    """The robot: a preset by name (``robot=husky``), or a file with ``--robot``."""

    def config(self) -> IngestConfig:
        """The settings alone."""
        return settings_of(self, IngestConfig)
