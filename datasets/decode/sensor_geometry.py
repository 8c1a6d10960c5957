"""Where sensors are and how they see: calibrations and transforms."""

from typing import Any

import numpy as np

from navtool.datasets.decode.header import NO_HEAD, head_of, nanoseconds
from navtool.datasets.decode.messages import CameraInfoSample, Transform, TransformsSample
from navtool.datasets.errors import DatasetsError
from navtool.pipeline.geometry.camera import CameraModel
from navtool.pipeline.geometry.transforms import transform_from_xyz_quaternion


def decode_camera_info(message: Any) -> CameraInfoSample:
    """``sensor_msgs/CameraInfo``; binning and region of interest are left to the image's own size.

    Raises:
        DatasetsError: The camera is not calibrated, or its lens model is unknown.
    """
    # ROS 1 writes the matrices in upper case, ROS 2 in lower case.
    upper = hasattr(message, "K")
    d, k, r, p = (getattr(message, name if upper else name.lower()) for name in "DKRP")
    try:
        camera = CameraModel(
            width=int(message.width),
            height=int(message.height),
            fx=float(k[0]),
            fy=float(k[4]),
            cx=float(k[2]),
            cy=float(k[5]),
            distortion_model=message.distortion_model or "none",
            distortion=tuple(float(x) for x in d) if message.distortion_model else (),
        )
    except ValueError as error:
        raise DatasetsError(f"this calibration cannot be used: {error}", cure="set the camera of the robot") from error
    return CameraInfoSample(
        **head_of(message)._asdict(),
        camera=camera,
        rectification=np.array(r, np.float64).reshape(3, 3),
        projection=np.array(p, np.float64).reshape(3, 4),
    )


def decode_transforms(message: Any) -> TransformsSample:
    """``tf2_msgs/TFMessage`` and the older ``tf/tfMessage``.

    Raises:
        DatasetsError: A rotation is no rotation.
    """
    return TransformsSample(**NO_HEAD._asdict(), transforms=tuple(_transform(x) for x in message.transforms))


def _transform(stamped: Any) -> Transform:
    move, turn = stamped.transform.translation, stamped.transform.rotation
    parent, child = stamped.header.frame_id, stamped.child_frame_id
    try:
        matrix = transform_from_xyz_quaternion(
            np.array([move.x, move.y, move.z]), np.array([turn.x, turn.y, turn.z, turn.w])
        )
    except ValueError as error:
        raise DatasetsError(f"the transform from {parent} to {child} has no rotation: {error}") from error
    return Transform(parent=parent, child=child, stamp_ns=nanoseconds(stamped.header.stamp), matrix=matrix)
