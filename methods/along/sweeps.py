"""LiDAR sweeps: level, still, at the sensor, with the sensor's place in the odometry."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Float64

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.streams.motion import Motion
from navtool.methods.along.observation import Reading, Skip, Ticks
from navtool.methods.along.streams import Cloud, Streams
from navtool.pipeline.arrays import Array

_FARTHEST_M = 1e7
"""No odometry is that far from its origin, not even one in the coordinates of a national grid."""


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
    """Stamp of the cloud, on the clock of the recording."""
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
        refuse(
            outside(self, 0, 5, "robot_radius_m", unit="m", cure="0 keeps all points"),
            outside(self, 0, 60, "odometry_gap_s", unit="s", above=True),
        )


class Sweeps(Ticks[Sweep]):
    """Each cloud of the LiDAR as a sweep.

    Guarantee: every cloud that gives none is skipped with its reason. Memory holds one sweep.

    Args:
        config: What becomes of a cloud.
    """

    reads: ClassVar[tuple[str, ...]] = ("lidar", "odometry")
    noun: ClassVar[str] = "clouds"

    def __init__(self, config: SweepConfig) -> None:
        self._config = config

    def count(self, streams: Streams) -> int:
        """How many clouds there are."""
        return len(streams.cloud_stamps_ns)

    def duration_s(self, streams: Streams) -> float:
        """The time from the first cloud to the last."""
        return float(np.ptp(streams.cloud_stamps_ns)) * 1e-9

    def readings(self, streams: Streams) -> Iterator[Reading[Sweep]]:
        """The sweeps in the order of record."""
        for cloud in streams.clouds():
            yield Reading(cloud.stamp_ns, partial(self._sweep, streams, cloud))

    def _sweep(self, streams: Streams, recorded: Cloud) -> Sweep | Skip:
        try:
            cloud = recorded.read()
        except DatasetsError as error:
            what = f"{streams.topics['lidar']}: a cloud cannot be decoded: {error.what}"
            return Skip("cannot be decoded", Note("cloud.undecodable", what))
        if cloud.intensity is None:
            return Skip("without intensities")
        not_finite = cloud.dropped_nonfinite if isinstance(cloud, PointCloud) else 0
        x, y, z = columns = np.ascontiguousarray(cloud.xyz.T)
        returned = (x != 0) | (y != 0) | (z != 0)
        finite = np.isfinite(cloud.intensity)
        drops = SweepDrops(
            not_finite=not_finite + int(np.count_nonzero(returned & ~finite)),
            no_return=int(np.count_nonzero(~returned)),
        )
        points = _Points(columns, cloud.intensity, cloud.time_s).kept(returned & finite)
        sweep = self._placed(streams, recorded.stamp_ns, points, drops)
        if not len(sweep.xyz):
            return Skip("no point left" if len(cloud.xyz) else "empty")
        return sweep

    def _placed(self, streams: Streams, stamp_ns: int, points: "_Points", drops: SweepDrops) -> Sweep:
        """The points around the sensor, in the base frame's axes, at the stamp."""
        base_lidar, motion = streams.base_lidar, streams.motion
        sensor = base_lidar[:3, 3:].astype(np.float32)
        columns, intensity, time_s = points
        columns = base_lidar[:3, :3].astype(np.float32) @ columns
        if self._config.deskew and motion is not None and time_s is not None and time_s.size:
            moved = motion.deskewed(columns + sensor, time_s, stamp_ns)
            columns = columns if moved is None else moved - sensor
        near = np.hypot(columns[0], columns[1]) < np.float32(self._config.robot_radius_m)
        if near.any():
            drops = drops._replace(own_body=int(np.count_nonzero(near)))
            columns, intensity = columns.compress(~near, axis=1), intensity[~near]
        pose = None if motion is None else sensor_pose(motion, stamp_ns, base_lidar)
        return Sweep(stamp_ns, columns.T, intensity, pose, drops)


class _Points(NamedTuple):
    """Points of a cloud, as recorded."""

    columns: Float32[Array, "3 p"]
    intensity: Float32[Array, " p"]
    time_s: Float32[Array, " p"] | None

    def kept(self, chosen: Bool[Array, " p"]) -> "_Points":
        """Those that are chosen."""
        if chosen.all():
            return self
        times = None if self.time_s is None else self.time_s[chosen]
        return _Points(self.columns.compress(chosen, axis=1), self.intensity[chosen], times)


def sensor_pose(motion: Motion, moment_ns: int, base_lidar: Float64[Array, "4 4"]) -> Float64[Array, "3"] | None:
    """X and y of the sensor and the yaw of the base at a moment of the robot's way; None where that is not known."""
    pose = motion.pose(moment_ns)
    if pose is None:
        return None
    x, y, _ = pose[:3, :3] @ base_lidar[:3, 3] + pose[:3, 3]
    if max(abs(x), abs(y)) > _FARTHEST_M:
        return None
    return np.array([x, y, np.arctan2(pose[1, 0], pose[0, 0])])
