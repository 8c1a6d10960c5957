"""Settings of ingest: the grid, the tolerances of each stream, the cloud, the reliabilities."""

from dataclasses import dataclass, field
from enum import StrEnum

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.datasets.streams.config import SyncConfig
from navtool.pipeline.cloud_reliability import CloudReliabilityConfig
from navtool.pipeline.image_reliability import ImageReliabilityConfig

PARENT = "{parent}"
"""As place: the name of each recording's folder."""


class Merge(StrEnum):
    """What is one recording."""

    file = "file"
    """Each file, and each rosbag2 folder."""
    folder = "folder"
    """All recordings that lie in one folder."""


@dataclass(kw_only=True, slots=True)
class IngestConfig:
    """Everything that decides what a recording becomes, beside the robot."""

    fps: int = 10
    """Rate of the grid in Hz, 1 to 60; one integer for the whole data set."""
    place: str = ""
    """Place of these recordings, for splits that never share one; ``{parent}`` takes each one's folder name."""
    merge: Merge = Merge.file
    """What is one recording: each file (and each rosbag2 folder), or all bags of a folder together, as of a mission."""
    voxel_m: float = 0.05
    """Edge of the voxels that thin a cloud before points are drawn at random, 0.001 to 2 m in whole millimetres."""
    sync: SyncConfig = field(default_factory=SyncConfig)
    """Which time counts, and how each stream is brought onto the grid."""
    deskew: bool = False
    """Whether a row's points are moved to where they were at the cloud's stamp, by odometry and their own times."""
    image_reliability: ImageReliabilityConfig = field(default_factory=ImageReliabilityConfig)
    """GrASPE eq. (1) and (2), on the frame at the camera's own resolution."""
    cloud_reliability: CloudReliabilityConfig = field(default_factory=CloudReliabilityConfig)
    """GrASPE eq. (3) to (5), on the cloud as recorded."""

    def __post_init__(self) -> None:
        name = f"{self.place}: a name, or {PARENT} for the name of each recording's folder"
        refuse(
            fault("place", name, when=self.place != PARENT and any(mark in self.place for mark in "{}")),
            outside(self, 1, 60, "fps", unit="Hz"),
            outside(self, 0.001, 2, "voxel_m", unit="m"),
        )
