"""Where sensors are and how they see: calibrations and transforms."""

from typing import Any

import numpy as np
from jaxtyping import Float64

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.header import NO_HEAD, head_of, nanoseconds
from navtool.datasets.decode.messages import CameraInfoSample, Region, Transform, TransformsSample
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.lens_names import lens_of
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion

_MOST = 1e9
"""No frame is mounted further away in metres, and no calibration has a larger number."""


def decode_camera_info(message: Any) -> CameraInfoSample:
    """``sensor_msgs/CameraInfo`` of the whole sensor; the part of it that is read out stands beside.

    Raises:
        DatasetsError: The camera is not calibrated, a number is not finite or beyond all measure, or its lens model is
            unknown.
    """
    # ROS 1 writes the matrices in upper case, ROS 2 in lower case.
    upper = hasattr(message, "K")
    d, k, r, p = (getattr(message, name if upper else name.lower()) for name in "DKRP")
    if not (np.abs(np.array([*d, *k, *r, *p], np.float64)) <= _MOST).all():
        raise DatasetsError(
            "this calibration cannot be used: it has numbers that are not finite or beyond 1e9",
            cure="set the camera of the robot",
        )
    try:
        lens = lens_of(message.distortion_model, tuple(float(x) for x in d))
        camera = CameraModel(
            width=int(message.width),
            height=int(message.height),
            fx=float(k[0]),
            fy=float(k[4]),
            cx=float(k[2]),
            cy=float(k[5]),
            distortion_model=lens.model,
            distortion=lens.coefficients,
        )
    except ValueError as error:
        raise DatasetsError(f"this calibration cannot be used: {error}", cure="set the camera of the robot") from error
    return CameraInfoSample(
        **head_of(message)._asdict(),
        camera=camera,
        rectification=np.array(r, np.float64).reshape(3, 3),
        projection=np.array(p, np.float64).reshape(3, 4),
        region=_region(message),
        told=lens.told,
    )


def _region(message: Any) -> Region:
    """Region of interest and binning (REP 104): zeros stand for the whole sensor, and for pixels as they are."""
    binning = max(int(getattr(message, "binning_x", 0)), 1), max(int(getattr(message, "binning_y", 0)), 1)
    roi = getattr(message, "roi", None)
    if roi is None or not (roi.width and roi.height):
        return Region(binning=binning)
    size = int(roi.width), int(roi.height)
    return Region(offset=(int(roi.x_offset), int(roi.y_offset)), size=size, binning=binning)


def decode_transforms(message: Any) -> TransformsSample:
    """``tf2_msgs/TFMessage`` and the older ``tf/tfMessage``.

    Raises:
        DatasetsError: A rotation is no rotation.
    """
    return TransformsSample(**NO_HEAD._asdict(), transforms=tuple(_transform(x) for x in message.transforms))


def pose_matrix(
    parent: str, child: str, xyz_m: Float64[Array, " 3"], quaternion: Float64[Array, " 4"]
) -> Float64[Array, "4 4"]:
    """The pose of the child frame in the parent frame.

    Raises:
        DatasetsError: The rotation is no rotation, or a number is not finite or beyond all measure.
    """
    numbers = np.concatenate([xyz_m, quaternion])
    if not (np.abs(numbers) <= _MOST).all():
        raise DatasetsError(f"the transform from {parent} to {child} has the numbers {numbers.tolist()}")
    try:
        return transform_from_xyz_quaternion(xyz_m, quaternion)
    except ValueError as error:
        raise DatasetsError(f"the transform from {parent} to {child} has no rotation: {error}") from error


def _transform(stamped: Any) -> Transform:
    move, turn = stamped.transform.translation, stamped.transform.rotation
    parent, child = stamped.header.frame_id, stamped.child_frame_id
    xyz_m, quaternion = np.array([move.x, move.y, move.z]), np.array([turn.x, turn.y, turn.z, turn.w])
    matrix = pose_matrix(parent, child, xyz_m, quaternion)
    return Transform(parent=parent, child=child, stamp_ns=nanoseconds(stamped.header.stamp), matrix=matrix)
