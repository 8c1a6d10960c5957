"""LiDAR sweeps as intensity maps take them: level, still, at the sensor, with the sensor's place in the odometry."""

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, Float64

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.store.whole_clouds import WholeCloud
from navtool.datasets.streams.motion import Motion
from navtool.pipeline.arrays import Array

_FARTHEST_M = 1e7
"""No odometry is that far from its origin, not even one in the coordinates of a national grid."""
_FOOTPRINT = "tf_static: "
"""How a height above the ground that the recording itself tells is called in a calibration's sources."""


class SweepDrops(NamedTuple):
    """Points that a sweep lacks, by reason."""

    not_finite: int = 0
    """A coordinate or the intensity is NaN or infinite. A data set lacks those of coordinates already."""
    no_return: int = 0
    """Recorded as (0, 0, 0)."""
    own_body: int = 0
    """Within the robot's radius of the sensor, seen from above."""


class Sweep(NamedTuple):
    """One LiDAR sweep around the sensor."""

    stamp_ns: int
    """Of the cloud, on the clock of the recording."""
    xyz: Float32[Array, "p 3"]
    """Metres, where they were at the stamp; the origin is the sensor, x and z point forward and up as the base's do."""
    intensity: Float32[Array, " p"]
    """In the sensor's own scale, finite."""
    odom_sensor: Float64[Array, "3"] | None
    """x and y of the sensor in the odometry frame, and the yaw of the base; None where odometry does not say."""
    drops: SweepDrops


@dataclass(kw_only=True, slots=True)
class SweepConfig:
    """What becomes of a cloud before it is mapped."""

    robot_radius_m: float = 0.4
    """Points nearer to the sensor than this, seen from above, are the robot's own body: 0 keeps all; up to 5 m."""
    deskew: bool = True
    """Whether points are moved to where they were at the cloud's stamp, by odometry and their own times."""
    odometry_gap_s: float = 0.25
    """Poses of the odometry further apart than this are not interpolated between, in (0, 60] seconds."""

    def __post_init__(self) -> None:
        if not 0 <= self.robot_radius_m <= 5:
            raise ValueError(f"robot_radius_m = {self.robot_radius_m} m is outside 0-5 m; 0 keeps all points")
        if not 0 < self.odometry_gap_s <= 60:
            raise ValueError(f"odometry_gap_s = {self.odometry_gap_s} s is outside (0, 60] s")


class Pending(NamedTuple):
    """A cloud that is read when it is wanted."""

    stamp_ns: int
    read: Callable[[], PointCloud | WholeCloud]
    """Raises DatasetsError where it cannot be decoded."""


class SweepSource(ABC):
    """Sweeps of one run, in the order of record.

    Guarantees: a recording and the data set that was ingested from it give the same sweeps, bit for bit, where ingest
    took the clouds' own stamps; and every cloud that gives none is counted in ``skipped``. Iterating streams: memory
    holds a few clouds. It may be iterated again; the counts begin anew then.

    Attributes:
        name: Of the recording or of the episode.
        topic: Of the clouds; where a data set was made from, that of its recording.
        clouds: How many there are.
        duration_s: From the first stamp to the last.
        calibration: The robot's geometry.
        motion: The robot's way by its odometry; None without one.
        notes: What a user should look at.
        skipped: Clouds without a sweep, by reason, of the iteration that ran last.
        config: What becomes of a cloud.
        odometry_frame: In which the way is; ``odom`` where it is not told.
    """

    def __init__(
        self,
        name: str,
        topic: str,
        calibration: Calibration,
        motion: Motion | None,
        config: SweepConfig,
    ) -> None:
        self.name, self.topic = name, topic
        self.calibration, self.motion, self.config = calibration, motion, config
        self.clouds, self.duration_s = 0, 0.0
        self.odometry_frame = "odom"
        self.notes: list[str] = []
        self.skipped: Counter[str] = Counter()
        if calibration.base_lidar is None:
            self.notes.append("lidar: its pose on the robot is unknown: its axes are taken for the base frame's, level")
        if motion is None:
            self.notes.append("odometry: there is none: points stay as measured, and nothing is known of the way")

    @property
    def base_lidar(self) -> Float64[Array, "4 4"]:
        """The pose of the sensor in the base frame; as if it were the base where nothing tells it."""
        return np.eye(4) if self.calibration.base_lidar is None else self.calibration.base_lidar

    @property
    def sensor_height_m(self) -> float | None:
        """Height of the sensor above the ground, where the recording or the robot's preset tells it; else None."""
        base_lidar, height = self.calibration.base_lidar, self.calibration.base_height_m
        told = height > 0 or self.calibration.sources.get("base_height_m", "").startswith(_FOOTPRINT)
        if base_lidar is None or not told:
            return None
        above = height + float(base_lidar[2, 3])
        return above if above > 0 else None

    def __iter__(self) -> Iterator[Sweep]:
        """The sweeps."""
        self.skipped = Counter()
        for cloud in self._pending():
            sweep = self._sweep(cloud)
            if sweep is not None:
                yield sweep

    @abstractmethod
    def _pending(self) -> Iterator[Pending]:
        """The clouds in the order of record, each to be read."""

    def _sweep(self, pending: Pending) -> Sweep | None:
        try:
            cloud = pending.read()
        except DatasetsError as error:
            self.skipped["cannot be decoded"] += 1
            if self.skipped["cannot be decoded"] == 1:
                self.notes.append(f"{self.topic}: a cloud cannot be decoded: {error.what}")
            return None
        if cloud.intensity is None:
            self.skipped["without intensities"] += 1
            return None
        not_finite = cloud.dropped_nonfinite if isinstance(cloud, PointCloud) else 0
        x, y, z = columns = np.ascontiguousarray(cloud.xyz.T)
        returned = (x != 0) | (y != 0) | (z != 0)
        finite = np.isfinite(cloud.intensity)
        drops = SweepDrops(
            not_finite=not_finite + int(np.count_nonzero(returned & ~finite)),
            no_return=int(np.count_nonzero(~returned)),
        )
        sweep = self._placed(pending.stamp_ns, columns, cloud.intensity, cloud.time_s, returned & finite, drops)
        if not len(sweep.xyz):
            self.skipped["no point left" if len(cloud.xyz) else "empty"] += 1
            return None
        return sweep

    def _placed(
        self,
        stamp_ns: int,
        columns: Float32[Array, "3 p"],
        intensity: Float32[Array, " p"],
        time_s: Float32[Array, " p"] | None,
        kept: Array,
        drops: SweepDrops,
    ) -> Sweep:
        """The kept points around the sensor, in the base frame's axes, at the stamp."""
        if not kept.all():
            columns, intensity = columns.compress(kept, axis=1), intensity[kept]
            time_s = None if time_s is None else time_s[kept]
        base_lidar = self.base_lidar
        sensor = base_lidar[:3, 3:].astype(np.float32)
        columns = base_lidar[:3, :3].astype(np.float32) @ columns
        if self.config.deskew and self.motion is not None and time_s is not None and time_s.size:
            moved = self.motion.deskewed(columns + sensor, time_s, stamp_ns)
            columns = columns if moved is None else moved - sensor
        near = np.hypot(columns[0], columns[1]) < np.float32(self.config.robot_radius_m)
        if near.any():
            drops = drops._replace(own_body=int(np.count_nonzero(near)))
            columns, intensity = columns.compress(~near, axis=1), intensity[~near]
        pose = None if self.motion is None else sensor_pose(self.motion, stamp_ns, base_lidar)
        return Sweep(stamp_ns, columns.T, intensity, pose, drops)


def sensor_pose(motion: Motion, moment_ns: int, base_lidar: Float64[Array, "4 4"]) -> Float64[Array, "3"] | None:
    """X and y of the sensor and the yaw of the base at a moment of the robot's way; None where that is not known."""
    pose = motion.pose(moment_ns)
    if pose is None:
        return None
    x, y, _ = pose[:3, :3] @ base_lidar[:3, 3] + pose[:3, 3]
    if max(abs(x), abs(y)) > _FARTHEST_M:
        return None
    return np.array([x, y, np.arctan2(pose[1, 0], pose[0, 0])])
