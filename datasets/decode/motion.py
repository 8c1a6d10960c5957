"""Poses and velocities: odometry, inertial sensors, commands, poses, satellite fixes."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from navtool.datasets.decode.header import NO_HEAD, Head, head_of
from navtool.datasets.decode.messages import ImuSample, NavSatSample, OdometrySample, PoseSample, TwistSample
from navtool.pipeline.arrays import Array


def decode_odometry(message: Any) -> OdometrySample:
    """``nav_msgs/Odometry``, without its covariances."""
    pose, twist = message.pose.pose, message.twist.twist
    return OdometrySample(
        **head_of(message)._asdict(),
        child_frame_id=message.child_frame_id,
        position=_vector(pose.position),
        orientation=_quaternion(pose.orientation),
        linear=_vector(twist.linear),
        angular=_vector(twist.angular),
    )


def decode_imu(message: Any) -> ImuSample:
    """``sensor_msgs/Imu``, without its covariances."""
    estimated = message.orientation_covariance[0] != -1
    return ImuSample(
        **head_of(message)._asdict(),
        angular_velocity=_vector(message.angular_velocity),
        linear_acceleration=_vector(message.linear_acceleration),
        orientation=_quaternion(message.orientation) if estimated else None,
    )


def decode_twist(message: Any) -> TwistSample:
    """``geometry_msgs/Twist``."""
    return _twist(NO_HEAD, message)


def decode_twist_stamped(message: Any) -> TwistSample:
    """``geometry_msgs/TwistStamped``."""
    return _twist(head_of(message), message.twist)


def decode_twist_with_covariance_stamped(message: Any) -> TwistSample:
    """``geometry_msgs/TwistWithCovarianceStamped``, without its covariance."""
    return _twist(head_of(message), message.twist.twist)


def decode_pose_stamped(message: Any) -> PoseSample:
    """``geometry_msgs/PoseStamped``."""
    return _pose(head_of(message), message.pose)


def decode_pose_with_covariance_stamped(message: Any) -> PoseSample:
    """``geometry_msgs/PoseWithCovarianceStamped``, without its covariance."""
    return _pose(head_of(message), message.pose.pose)


def decode_nav_sat_fix(message: Any) -> NavSatSample:
    """``sensor_msgs/NavSatFix``, without its covariance."""
    return NavSatSample(
        **head_of(message)._asdict(),
        latitude_deg=float(message.latitude),
        longitude_deg=float(message.longitude),
        altitude_m=float(message.altitude),
        has_fix=int(message.status.status) >= 0,
    )


def _twist(head: Head, twist: Any) -> TwistSample:
    return TwistSample(**head._asdict(), linear=_vector(twist.linear), angular=_vector(twist.angular))


def _pose(head: Head, pose: Any) -> PoseSample:
    return PoseSample(**head._asdict(), position=_vector(pose.position), orientation=_quaternion(pose.orientation))


def _vector(value: Any) -> Float64[Array, " 3"]:
    return np.array([value.x, value.y, value.z], np.float64)


def _quaternion(value: Any) -> Float64[Array, " 4"]:
    return np.array([value.x, value.y, value.z, value.w], np.float64)
