"""Foxglove's own schemas, as JSON, protobuf or ROS 2 messages: their fields are the same in all three."""

from types import SimpleNamespace
from typing import Any

import numpy as np

from navtool.base.errors import DatasetsError
from navtool.datasets.decode.compressed_image import decode_compressed_image
from navtool.datasets.decode.header import joined_ns
from navtool.datasets.decode.image import decode_image
from navtool.datasets.decode.messages import (
    CameraInfoSample,
    ImageFrame,
    PointCloud,
    PoseSample,
    Transform,
    TransformsSample,
    VideoPacket,
)
from navtool.datasets.decode.point_cloud import decode_point_cloud
from navtool.datasets.decode.sensor_geometry import decode_camera_info, pose_matrix
from navtool.datasets.decode.video_packet import codec_in, video_packet
from navtool.pipeline.geometry.transforms import apply_transform

_POINT_FIELD = {1: 2, 2: 1, 3: 4, 4: 3, 5: 6, 6: 5, 7: 7, 8: 8}
"""Foxglove's numeric types by those of ``sensor_msgs/PointField``."""
_NUMERIC = ("UNKNOWN", "UINT8", "INT8", "UINT16", "INT16", "UINT32", "INT32", "FLOAT32", "FLOAT64")


def decode_foxglove_compressed_video(message: Any) -> VideoPacket:
    """``foxglove.CompressedVideo``: one picture's packet."""
    like = SimpleNamespace(header=_header(message))
    return video_packet(like, codec_in(message.format), message.format, _bytes(message.data))


def decode_foxglove_compressed_image(message: Any) -> ImageFrame | VideoPacket:
    """``foxglove.CompressedImage``: JPEG or PNG."""
    like = SimpleNamespace(header=_header(message), format=message.format, data=_bytes(message.data))
    return decode_compressed_image(like)


def decode_foxglove_raw_image(message: Any) -> ImageFrame:
    """``foxglove.RawImage``, in the encodings of ``sensor_msgs/Image``; samples of 16 bits are little-endian."""
    like = SimpleNamespace(
        header=_header(message),
        width=int(message.width),
        height=int(message.height),
        encoding=message.encoding,
        step=int(message.step),
        is_bigendian=0,
        data=_bytes(message.data),
    )
    return decode_image(like)


def decode_foxglove_point_cloud(message: Any) -> PointCloud:
    """``foxglove.PointCloud``, its points moved by the pose that it gives itself in its frame."""
    data, stride = _bytes(message.data), int(message.point_stride)
    if stride < 1:
        raise DatasetsError(f"points of {stride} bytes")
    fields = [
        SimpleNamespace(name=field.name, offset=int(field.offset), datatype=_datatype(field.type), count=1)
        for field in message.fields
    ]
    points = data.size // stride
    cloud = decode_point_cloud(
        SimpleNamespace(
            header=_header(message),
            width=points,
            height=1,
            fields=fields,
            is_bigendian=False,
            point_step=stride,
            row_step=stride * points,
            data=data,
        )
    )
    pose = _pose(getattr(message, "pose", None))
    if pose is None or np.array_equal(pose, np.eye(4)):
        return cloud
    return PointCloud(**{**vars(cloud), "xyz": apply_transform(pose, cloud.xyz).astype(np.float32)})


def decode_foxglove_pose(message: Any) -> PoseSample:
    """``foxglove.PoseInFrame``."""
    header, pose = _header(message), message.pose
    return PoseSample(
        stamp_ns=_nanoseconds(message.timestamp),
        frame_id=header.frame_id,
        position=_numbers(pose.position, "xyz"),
        orientation=_numbers(pose.orientation, "xyzw"),
    )


def decode_foxglove_transform(message: Any) -> TransformsSample:
    """``foxglove.FrameTransform``."""
    return TransformsSample(stamp_ns=None, frame_id="", transforms=(_transform(message),))


def decode_foxglove_transforms(message: Any) -> TransformsSample:
    """``foxglove.FrameTransforms``."""
    return TransformsSample(stamp_ns=None, frame_id="", transforms=tuple(_transform(x) for x in message.transforms))


def decode_foxglove_calibration(message: Any) -> CameraInfoSample:
    """``foxglove.CameraCalibration``."""
    matrices = {name: _list(getattr(message, name, None) or getattr(message, name.lower(), [])) for name in "DKRP"}
    matrices["R"] = matrices["R"] or np.eye(3).ravel().tolist()
    matrices["P"] = matrices["P"] or [0.0] * 12
    if len(matrices["K"]) != 9:
        raise DatasetsError("a calibration without the intrinsic matrix K", cure="set the camera of the robot")
    return decode_camera_info(
        SimpleNamespace(
            header=_header(message),
            width=int(message.width),
            height=int(message.height),
            distortion_model=message.distortion_model,
            **matrices,
        )
    )


def _header(message: Any) -> SimpleNamespace:
    stamp = _nanoseconds(message.timestamp)
    time = SimpleNamespace(sec=stamp // 1_000_000_000, nanosec=stamp % 1_000_000_000)
    return SimpleNamespace(stamp=time, frame_id=str(getattr(message, "frame_id", "")))


def _nanoseconds(time: Any) -> int:
    """JSON says sec and nsec, protobuf seconds and nanos, ROS sec and nanosec."""
    for seconds, rest in (("sec", "nsec"), ("seconds", "nanos"), ("sec", "nanosec")):
        if hasattr(time, seconds) and hasattr(time, rest):
            return joined_ns(getattr(time, seconds), getattr(time, rest))
    raise DatasetsError("a timestamp without seconds")


def _bytes(data: Any) -> Any:
    return data if isinstance(data, np.ndarray) else np.frombuffer(data, np.uint8)


def _datatype(kind: Any) -> int:
    number = _NUMERIC.index(kind) if kind in _NUMERIC else int(kind)
    return _POINT_FIELD.get(number, 0)


def _list(values: Any) -> list[float]:
    return [float(value) for value in values]


def _numbers(value: Any, names: str) -> Any:
    return np.array([float(getattr(value, name, 0.0)) for name in names], np.float64)


def _pose(pose: Any) -> Any:
    if pose is None:
        return None
    quaternion = _numbers(pose.orientation, "xyzw")
    if not quaternion.any():
        quaternion[3] = 1.0
    return pose_matrix("its frame", "the points", _numbers(pose.position, "xyz"), quaternion)


def _transform(message: Any) -> Transform:
    parent, child = str(message.parent_frame_id), str(message.child_frame_id)
    matrix = pose_matrix(parent, child, _numbers(message.translation, "xyz"), _numbers(message.rotation, "xyzw"))
    return Transform(parent=parent, child=child, stamp_ns=_nanoseconds(message.timestamp), matrix=matrix)
