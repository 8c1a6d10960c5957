"""The small streams of sensors in the base frame's axes, wherever they are mounted."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from jaxtyping import Float64

from navtool.datasets.robot.calibration import Calibration
from navtool.datasets.streams.rows import IMU_COLUMNS, ODOMETRY_COLUMNS
from navtool.datasets.streams.timed_stream import TimedStream, unit_quaternions
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import (
    invert_transform,
    quaternion_from_transform,
    transform_from_xyz_quaternion,
)


def in_base_axes(streams: Mapping[str, TimedStream], calibration: Calibration) -> dict[str, TimedStream]:
    """The streams with IMU and odometry turned into the base frame, where their poses in it are known.

    An IMU is only turned, not moved: the accelerations of its lever arm stay in. An odometry's pose becomes that of the
    base frame, its velocity that of the base frame's origin. What was recorded as NaN stays NaN.
    """
    aligned = dict(streams)
    if "imu" in streams and calibration.base_imu is not None:
        aligned["imu"] = _turned_imu(streams["imu"], calibration.base_imu)
    if "odometry" in streams and calibration.base_odometry is not None:
        aligned["odometry"] = _moved_odometry(streams["odometry"], calibration.base_odometry)
    return aligned


def _turned_imu(stream: TimedStream, base_imu: Float64[Array, "4 4"]) -> TimedStream:
    if stream.recorded.columns != IMU_COLUMNS or np.array_equal(base_imu[:3, :3], np.eye(3)):
        return stream
    turn = base_imu[:3, :3].T
    return replace(stream, values=np.hstack([stream.values[:, :3] @ turn, stream.values[:, 3:] @ turn]))


def _moved_odometry(stream: TimedStream, base_child: Float64[Array, "4 4"]) -> TimedStream:
    if stream.recorded.columns != ODOMETRY_COLUMNS or np.array_equal(base_child, np.eye(4)):
        return stream
    values = stream.values.copy()
    known = np.isfinite(values[:, :7]).all(axis=1)
    odom_child = transform_from_xyz_quaternion(values[known, :3], unit_quaternions(stream)[known])
    odom_base = odom_child @ invert_transform(base_child)
    values[known, :3] = odom_base[:, :3, 3]
    values[known, 3:7] = quaternion_from_transform(odom_base)
    turn = base_child[:3, :3].T
    angular = stream.values[:, 10:] @ turn
    values[:, 7:10] = stream.values[:, 7:10] @ turn - np.cross(angular, base_child[:3, 3])
    values[:, 10:] = angular
    return replace(stream, values=values)
