"""What ``navtool intensity-map`` is configured with."""

from dataclasses import dataclass, field, fields

from navtool.datasets.ingest.config import Merge
from navtool.datasets.robot.config import RobotConfig
from navtool.methods.intensity_map.config import MapRunConfig


@dataclass(kw_only=True, slots=True)
class IntensityMapJob(MapRunConfig):
    """The settings of the maps, and how a recording is read; a data set was read at ingest."""

    robot: RobotConfig = field(default_factory=RobotConfig)
    """The robot: a preset by name (``robot=husky``), or a file with ``--robot``."""
    merge: Merge = Merge.file
    """Whether all bags in a folder are one recording: file or folder, as for ingest."""

    def config(self) -> MapRunConfig:
        """The settings of the maps alone."""
        return MapRunConfig(**{entry.name: getattr(self, entry.name) for entry in fields(MapRunConfig)})
