"""Settings of ingest: the grid, the tolerances of each stream, the cloud, the reliabilities."""

import math
from dataclasses import dataclass, field
from enum import StrEnum

from navtool.datasets.ingest.clock import Clock
from navtool.datasets.sync import Method
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
class StreamClock:
    """Which time of a stream's messages counts."""

    clock: Clock = Clock.auto
    """auto, header or record."""


@dataclass(kw_only=True, slots=True)
class StreamSync(StreamClock):
    """How a stream is brought onto the grid."""

    method: Method
    """nearest, hold or linear; frames and clouds are never mixed, so for them not linear."""
    tolerance_s: float
    """nearest: how far from the tick; hold: how old; linear: how far apart the two around it. In (0, 60] seconds."""


@dataclass(kw_only=True, slots=True)
class SyncConfig:
    """The policy of time: each stream's clock, method and tolerance."""

    image: StreamSync = field(default_factory=lambda: StreamSync(method=Method.nearest, tolerance_s=0.06))
    """Camera frames; at the grid's own rate a frame is at most half a period away."""
    lidar: StreamSync = field(default_factory=lambda: StreamSync(method=Method.nearest, tolerance_s=0.06))
    """Clouds, by the stamp of their header."""
    odometry: StreamSync = field(default_factory=lambda: StreamSync(method=Method.linear, tolerance_s=0.25))
    """Speeds and poses; attitudes along the shortest turn (slerp)."""
    imu: StreamSync = field(default_factory=lambda: StreamSync(method=Method.linear, tolerance_s=0.1))
    """Accelerations and turning rates."""
    joints: StreamSync = field(default_factory=lambda: StreamSync(method=Method.linear, tolerance_s=0.1))
    """Joint states."""
    battery: StreamSync = field(default_factory=lambda: StreamSync(method=Method.hold, tolerance_s=5.0))
    """Battery current."""
    command: StreamSync = field(default_factory=lambda: StreamSync(method=Method.hold, tolerance_s=0.5))
    """Commanded velocities."""
    intervention: StreamClock = field(default_factory=StreamClock)
    """The operator's flag; it stays at its own rate."""
    clock_step_s: float = 0.5
    """Steps of a header clock beyond this are taken out: behind them, time goes on at the pace of record."""

    def __post_init__(self) -> None:
        seconds = {"clock_step_s": self.clock_step_s}
        seconds |= {f"{name}.tolerance_s": stream.tolerance_s for name, stream in self.gridded().items()}
        for name, value in seconds.items():
            if not (math.isfinite(value) and 0 < value <= 60):
                raise ValueError(f"sync.{name} = {value} s is outside (0, 60] s")
        for name in ("image", "lidar"):
            if self.gridded()[name].method is Method.linear:
                raise ValueError(f"sync.{name}.method = linear: frames and clouds are not mixed; use nearest or hold")

    def gridded(self) -> dict[str, StreamSync]:
        """The streams that are brought onto the grid, by name."""
        return {
            "image": self.image,
            "lidar": self.lidar,
            "odometry": self.odometry,
            "imu": self.imu,
            "joints": self.joints,
            "battery": self.battery,
            "command": self.command,
        }

    def clock_of(self, stream: str) -> Clock:
        """Which time of a stream counts."""
        return self.intervention.clock if stream == "intervention" else self.gridded()[stream].clock


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
        if self.place != PARENT and any(mark in self.place for mark in "{}"):
            raise ValueError(f"place = {self.place}: a name, or {PARENT} for the name of each recording's folder")
        if not 1 <= self.fps <= 60:
            raise ValueError(f"fps = {self.fps} Hz is outside 1 to 60 Hz")
        if not (math.isfinite(self.voxel_m) and 0.001 <= self.voxel_m <= 2):
            raise ValueError(f"voxel_m = {self.voxel_m} m is outside 0.001 to 2 m")
