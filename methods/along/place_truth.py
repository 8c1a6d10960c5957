"""What is known to stand in a place, around the sensor at the moment of a sweep."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, UInt8

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.messages import OdometrySample, StringSample
from navtool.datasets.recording import Recording
from navtool.datasets.streams.motion import Motion
from navtool.methods.along.annotations import Annotations, parse_annotations
from navtool.methods.along.streams import Streams
from navtool.methods.along.sweeps import Sweep, sensor_pose
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.truth import Outline, truth_classes

OBSTACLES_TOPIC, ODOMETRY_TOPIC = "/ground_truth/obstacles", "/ground_truth/odometry"
"""What a simulated recording knows of its place, and of the robot's own."""
_TEXT = "std_msgs/msg/String"
TRUTH_CURE = "name annotations in the frame of its odometry with --truth; docs/annotations.md has the format"


@dataclass(frozen=True, slots=True)
class PlaceTruth:
    """Outlines, and where the robot is among them."""

    annotations: Annotations
    motion: Motion | None
    """The robot's way in the outlines' frame; None where that is the frame of its odometry, or a fixed one."""

    def in_odometry(self, streams: Streams) -> "PlaceTruth":
        """The same in the frame of a run's odometry, unless the robot's way among the outlines is known besides.

        Raises:
            DatasetsError: The outlines are in another frame, which no static transform joins with it.
        """
        frame, wanted = self.annotations.frame_id, streams.odometry_frame
        if self.motion is not None or frame.lstrip("/") == wanted.lstrip("/"):
            return self
        pose = streams.calibration.recorded.tree.pose(wanted, frame)
        if pose is None:
            what = f"the outlines are in the frame {frame!r}, the odometry of {streams.name} is in {wanted!r}"
            cure = f"draw them in {wanted!r}, or record the static transform between the two"
            raise DatasetsError(f"{what}, and no static transform joins them", cure=cure)
        moved = tuple(
            Outline(one.what, one.corners_m @ pose[:2, :2].T + pose[:2, 3]) for one in self.annotations.outlines
        )
        return PlaceTruth(Annotations(wanted, moved), None)

    def classes_around(
        self, sweep: Sweep, base_lidar: Float64[Array, "4 4"], grid: GridConfig
    ) -> UInt8[Array, "n n"] | None:
        """The true `CellClass` of each cell around the sensor; None where the robot's place is not known then."""
        pose = sweep.odom_sensor
        if self.motion is not None:
            pose = sensor_pose(self.motion, sweep.stamp_ns, base_lidar)
        return None if pose is None else truth_classes(self.annotations.outlines, pose, grid)


def recorded_truth(recording: Recording, odometry_gap_s: float) -> PlaceTruth | None:
    """What a simulated recording knows to stand in its place; None where it says nothing of it.

    Args:
        recording: It is open.
        odometry_gap_s: True poses further apart than this are not interpolated between.

    Raises:
        DatasetsError: It is said in another form, or not where the robot is.
    """
    topics = {topic.name: topic.type for topic in recording.topics if topic.count}
    if topics.get(OBSTACLES_TOPIC) != _TEXT:  # another recorder's topic of this name says something else
        return None
    if ODOMETRY_TOPIC not in topics:
        what = f"has {OBSTACLES_TOPIC}, but not {ODOMETRY_TOPIC}: where the robot is among them is not known"
        raise DatasetsError(what, where=recording.path, cure=TRUTH_CURE)
    annotations, poses = None, dict[int, OdometrySample]()
    for raw in recording.messages((OBSTACLES_TOPIC, ODOMETRY_TOPIC)):
        sample = recording.decode(raw)
        if isinstance(sample, StringSample):
            annotations = parse_annotations(sample.value, f"{recording.path}: {OBSTACLES_TOPIC}")
        elif isinstance(sample, OdometrySample):
            poses[raw.record_ns if sample.stamp_ns is None else sample.stamp_ns] = sample
    if annotations is None or not poses:
        what = f"{OBSTACLES_TOPIC} and {ODOMETRY_TOPIC} are no std_msgs/String and nav_msgs/Odometry"
        raise DatasetsError(what, where=recording.path, cure=TRUTH_CURE)
    stamps = sorted(poses)
    motion = Motion(
        np.array(stamps, dtype=np.int64),
        np.stack([poses[stamp].position for stamp in stamps]),
        np.stack([poses[stamp].orientation for stamp in stamps]),
        odometry_gap_s,
    )
    return PlaceTruth(annotations, motion)
