"""Settings of ingest: the grid, the tolerances of each stream, the cloud, the reliabilities."""

import math
from dataclasses import dataclass, field, fields
from enum import StrEnum

from navtool.datasets.ingest.clock import Clock
from navtool.pipeline.cloud_reliability import CloudReliabilityConfig
from navtool.pipeline.image_reliability import ImageReliabilityConfig


class Merge(StrEnum):
    """What is one recording."""

    file = "file"
    """Each file, and each rosbag2 folder."""
    folder = "folder"
    """All recordings that lie in one folder."""


@dataclass(kw_only=True, slots=True)
class SyncConfig:
    """How far from a tick a sample may lie and still serve it, in seconds."""

    image_tolerance_s: float = 0.06
    """Nearest frame; a camera at the grid's own rate is at most half a period away."""
    lidar_tolerance_s: float = 0.06
    """Nearest cloud, by the stamp of its header."""
    state_max_gap_s: float = 0.25
    """Odometry is interpolated between two samples that are no further apart than this."""
    imu_max_gap_s: float = 0.1
    """The IMU likewise."""
    joints_max_gap_s: float = 0.1
    """Joint states likewise."""
    battery_max_age_s: float = 5.0
    """The newest battery state holds for this long."""
    command_max_age_s: float = 0.5
    """The newest command holds for this long."""
    clock_step_s: float = 0.5
    """Steps of a header clock beyond this are taken out: behind them, time goes on at the pace of record."""

    def __post_init__(self) -> None:
        for entry in fields(self):
            value: float = getattr(self, entry.name)
            if not (math.isfinite(value) and 0 < value <= 60):
                raise ValueError(f"sync.{entry.name} = {value} s is outside (0, 60] s")


@dataclass(kw_only=True, slots=True)
class ClockConfig:
    """Which time of its messages counts, per stream: auto, header or record."""

    image: Clock = Clock.auto
    """Camera frames."""
    lidar: Clock = Clock.auto
    """Clouds."""
    odometry: Clock = Clock.auto
    """Odometry."""
    imu: Clock = Clock.auto
    """IMU."""
    joints: Clock = Clock.auto
    """Joint states."""
    battery: Clock = Clock.auto
    """Battery."""
    command: Clock = Clock.auto
    """Commanded velocities."""
    intervention: Clock = Clock.auto
    """The operator's flag."""

    def of(self, stream: str) -> Clock:
        """The choice for a stream."""
        choice: Clock = getattr(self, stream)
        return choice


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
    """Edge of the voxels by which a cloud is thinned before points are drawn at random, in metres; 0 turns it off."""
    sync: SyncConfig = field(default_factory=SyncConfig)
    """Tolerances."""
    clock: ClockConfig = field(default_factory=ClockConfig)
    """Header stamps or times of record."""
    deskew: bool = False
    """Whether a row's points are moved to where they were at the cloud's stamp, by odometry and their own times."""
    image_reliability: ImageReliabilityConfig = field(default_factory=ImageReliabilityConfig)
    """GrASPE eq. (1) and (2), on the frame at the camera's own resolution."""
    cloud_reliability: CloudReliabilityConfig = field(default_factory=CloudReliabilityConfig)
    """GrASPE eq. (3) to (5), on the cloud as recorded."""

    def __post_init__(self) -> None:
        if not 1 <= self.fps <= 60:
            raise ValueError(f"fps = {self.fps} Hz is outside 1 to 60 Hz")
        if not (math.isfinite(self.voxel_m) and 0 <= self.voxel_m <= 2):
            raise ValueError(f"voxel_m = {self.voxel_m} m is outside 0 to 2 m")
