"""The streams of a recording or an episode after the first look at it: geometry, odometry, clouds."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64, Int64

from navtool.base.note import Note
from navtool.datasets.decode.messages import PointCloud
from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.store.whole_clouds import WholeCloud
from navtool.methods.along.odometry_table import OdometryTable
from navtool.pipeline.arrays import Array

_FOOTPRINT = "tf_static: "
"""How a calibration's sources call a height above the ground that comes from the recording itself."""


class Cloud(NamedTuple):
    """A cloud as recorded, decoded when it is wanted."""

    stamp_ns: int
    read: Callable[[], PointCloud | WholeCloud]
    """Raises DatasetsError where it cannot be decoded."""


class Streams(ABC):
    """What a recording or an episode holds, on one clock and in the base frame's axes.

    Guarantee: a recording and the data set that was ingested from it, with the same robot and settings of time, give
    the same values, bit for bit.

    Attributes:
        name: Of the recording or of the episode.
        topics: The topic of each stream that is there; where a data set was made from, that of its recording.
        calibration: The robot's geometry.
        odometry: Poses and speeds of the base frame; None where there are none.
        motion: The robot's way by them.
        odometry_frame: In which the way is; ``odom`` where it is not known.
        notes: What a user should look at.
    """

    def __init__(
        self,
        name: str,
        topics: Mapping[str, str],
        calibration: Calibration,
        odometry: OdometryTable | None,
        odometry_gap_s: float,
    ) -> None:
        self.name, self.topics, self.calibration = name, topics, calibration
        self.odometry, self.odometry_frame = odometry, "odom"
        self.motion = None if odometry is None else odometry.motion(odometry_gap_s)
        self.notes: list[Note] = []
        if "lidar" in topics and calibration.base_lidar is None:
            what = "lidar: its pose on the robot is unknown: its axes are taken for the base frame's, level"
            self.notes.append(Note("lidar.taken-for-level", what))
        if "lidar" in topics and odometry is None:
            what = "odometry: there is none: points stay as measured, and nothing is known of the way"
            self.notes.append(Note("odometry.none-to-walk-by", what))

    @property
    def base_lidar(self) -> Float64[Array, "4 4"]:
        """The pose of the LiDAR in the base frame; that of the base where it is not known."""
        return np.eye(4) if self.calibration.base_lidar is None else self.calibration.base_lidar

    @property
    def lidar_height_m(self) -> float | None:
        """Height of the LiDAR above the ground, where the recording or the robot's preset has it; else None."""
        base_lidar, height = self.calibration.base_lidar, self.calibration.base_height_m
        known = height > 0 or self.calibration.sources.get("base_height_m", "").startswith(_FOOTPRINT)
        if base_lidar is None or not known:
            return None
        above = height + float(base_lidar[2, 3])
        return above if above > 0 else None

    @property
    @abstractmethod
    def cloud_stamps_ns(self) -> Int64[Array, " clouds"]:
        """When each cloud was measured, in the order of record; empty without a LiDAR."""

    @abstractmethod
    def clouds(self) -> Iterator[Cloud]:
        """The clouds in the order of record, each to be read; may be iterated again."""
