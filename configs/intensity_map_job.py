"""What ``navtool intensity-map`` is configured with."""

from dataclasses import dataclass, field

from navtool.configs.settings_of import settings_of
from navtool.datasets.ingest.config import Merge
from navtool.datasets.robot.config import RobotConfig
from navtool.datasets.streams.config import SyncConfig
from navtool.methods.intensity_map.config import MapRunConfig


@dataclass(kw_only=True, slots=True)
class IntensityMapJob(MapRunConfig):
    """The settings of the maps, and how a recording is read; a data set was read at ingest."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    """The robot: a preset by name (``robot=husky``), or a file with ``--robot``."""
    merge: Merge = Merge.file
    """Whether all bags in a folder are one recording: file or folder, as for ingest."""
    sync: SyncConfig = field(default_factory=SyncConfig)
    """Which time of a recording's messages counts, as for ingest: ``sync.*.clock`` and ``sync.clock_step_s``."""

    def config(self) -> MapRunConfig:
        """The settings of the maps alone."""
        return settings_of(self, MapRunConfig)
