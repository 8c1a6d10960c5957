"""The message types that navtool reads: one row a type, with its decoder and the streams that it can feed."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

from navtool.datasets.decode.channel_cloud import decode_channel_cloud
from navtool.datasets.decode.compressed_cloud import decode_compressed_cloud
from navtool.datasets.decode.compressed_image import decode_compressed_image
from navtool.datasets.decode.foxglove import (
    decode_foxglove_calibration,
    decode_foxglove_compressed_image,
    decode_foxglove_compressed_video,
    decode_foxglove_point_cloud,
    decode_foxglove_pose,
    decode_foxglove_raw_image,
    decode_foxglove_transform,
    decode_foxglove_transforms,
)
from navtool.datasets.decode.image import decode_image
from navtool.datasets.decode.laser_scan import decode_laser_scan
from navtool.datasets.decode.livox import decode_livox
from navtool.datasets.decode.messages import Decoded
from navtool.datasets.decode.motion import (
    decode_imu,
    decode_nav_sat_fix,
    decode_odometry,
    decode_pose_stamped,
    decode_pose_with_covariance_stamped,
    decode_twist,
    decode_twist_stamped,
    decode_twist_with_covariance_stamped,
)
from navtool.datasets.decode.point_cloud import decode_point_cloud
from navtool.datasets.decode.robot_state import (
    decode_battery_state,
    decode_bool,
    decode_float,
    decode_joint_state,
    decode_joy,
    decode_string,
)
from navtool.datasets.decode.sensor_geometry import decode_camera_info, decode_transforms
from navtool.datasets.decode.velodyne_packets import decode_velodyne_scan
from navtool.datasets.decode.vendor_state import (
    decode_anymal_battery,
    decode_anymal_state,
    decode_clearpath_power,
    decode_husky_status,
    decode_jackal_status,
    decode_racepak_controls,
    decode_spot_batteries,
    decode_unitree_sport_state,
    decode_unitree_state,
    decode_warthog_status,
)
from navtool.datasets.decode.video_packet import decode_ffmpeg_packet

TRANSFORMS = "transforms"
"""What transforms feed; their topics are always read, so that it is no stream of the stream table."""

type Decoder = Callable[[Any], Decoded]
"""Takes an object with the fields of the type's definition."""


@dataclass(frozen=True, slots=True)
class Message:
    """One message type: how it is decoded, and what it can feed."""

    type: str
    """As ``pkg/msg/Name``, or by the name of a schema of Foxglove's."""
    decode: Decoder
    proposed: tuple[str, ...] = ()
    """Streams that a topic of the type may be taken for by its name alone."""
    named: tuple[str, ...] = ()
    """Streams that are read from it only where the robot file names the topic: by itself it may be anything."""
    planar: bool = False
    """Whether its clouds lie in one plane; proposed only where a recording has no other cloud."""
    video: bool = False
    """Whether its pictures need those of messages before."""
    packed: bool = False
    """Whether its clouds lost something when they were compressed: others of the same sensor are better."""
    own_definition: bool = False
    """Whether only a recording itself defines it; navtool brings no definition of a vendor's type."""
    unused: str = ""
    """Why such a topic is left out where the robot file does not name it; empty for the usual reasons."""


def _foxglove(name: str, decode: Decoder, **fields: Any) -> tuple[Message, Message]:
    """A type of Foxglove's, in its own schema languages and as a ROS 2 message."""
    return Message(f"foxglove.{name}", decode, **fields), Message(f"foxglove_msgs/msg/{name}", decode, **fields)


def _vendor(kind: str, decode: Decoder, *named: str) -> Message:
    return Message(kind, decode, named=named, own_definition=True)


_POSES = "poses without speeds; name it as odometry in the robot file"
_OWN_POSES = f"{_POSES} if they are the robot's own"

_ROWS = (
    Message("sensor_msgs/msg/Image", decode_image, ("camera",)),
    Message("sensor_msgs/msg/CompressedImage", decode_compressed_image, ("camera",)),
    *_foxglove("RawImage", decode_foxglove_raw_image, proposed=("camera",)),
    *_foxglove("CompressedImage", decode_foxglove_compressed_image, proposed=("camera",)),
    *_foxglove("CompressedVideo", decode_foxglove_compressed_video, proposed=("camera",), video=True),
    Message("ffmpeg_image_transport_msgs/msg/FFMPEGPacket", decode_ffmpeg_packet, ("camera",), video=True),
    Message("sensor_msgs/msg/CameraInfo", decode_camera_info, ("camera_info",)),
    *_foxglove("CameraCalibration", decode_foxglove_calibration, proposed=("camera_info",)),
    Message("sensor_msgs/msg/PointCloud2", decode_point_cloud, ("lidar",)),
    Message("point_cloud_interfaces/msg/CompressedPointCloud2", decode_compressed_cloud, ("lidar",), packed=True),
    Message("draco_point_cloud_transport/msg/CompressedPointCloud2", decode_compressed_cloud, ("lidar",), packed=True),
    Message("velodyne_msgs/msg/VelodyneScan", decode_velodyne_scan, ("lidar",)),
    Message("livox_ros_driver/msg/CustomMsg", decode_livox, ("lidar",)),
    Message("livox_ros_driver2/msg/CustomMsg", decode_livox, ("lidar",)),
    Message("livox_interfaces/msg/CustomMsg", decode_livox, ("lidar",)),
    *_foxglove("PointCloud", decode_foxglove_point_cloud, proposed=("lidar",)),
    Message("sensor_msgs/msg/LaserScan", decode_laser_scan, ("lidar",), planar=True),
    Message(
        "sensor_msgs/msg/PointCloud",
        decode_channel_cloud,
        named=("lidar",),
        unused="the old cloud type, of sensors or of features; name it as lidar in the robot file",
    ),
    Message("nav_msgs/msg/Odometry", decode_odometry, ("odometry",), named=("command",)),
    Message("geometry_msgs/msg/PoseStamped", decode_pose_stamped, named=("odometry",), unused=_OWN_POSES),
    Message(
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        decode_pose_with_covariance_stamped,
        named=("odometry",),
        unused=_OWN_POSES,
    ),
    *_foxglove("PoseInFrame", decode_foxglove_pose, named=("odometry",), unused=_POSES),
    _vendor("unitree_go/msg/SportModeState", decode_unitree_sport_state, "odometry"),
    Message("sensor_msgs/msg/Imu", decode_imu, ("imu",)),
    Message("sensor_msgs/msg/JointState", decode_joint_state, ("joints",)),
    Message("sensor_msgs/msg/BatteryState", decode_battery_state, ("battery",)),
    Message("geometry_msgs/msg/Twist", decode_twist, ("command",)),
    Message("geometry_msgs/msg/TwistStamped", decode_twist_stamped, ("command",)),
    Message(
        "sensor_msgs/msg/Joy",
        decode_joy,
        named=("command",),
        unused="joystick axes are not velocities; name it as command, with `joy`, in the robot file",
    ),
    Message("geometry_msgs/msg/TwistWithCovarianceStamped", decode_twist_with_covariance_stamped, named=("command",)),
    Message("std_msgs/msg/Bool", decode_bool, ("intervention",)),
    Message("std_msgs/msg/Float32", decode_float, named=("battery",)),
    Message("std_msgs/msg/Float64", decode_float, named=("battery",)),
    _vendor("anymal_msgs/msg/BatteryState", decode_anymal_battery, "battery"),
    _vendor("clearpath_platform_msgs/msg/Power", decode_clearpath_power, "battery"),
    _vendor("jackal_msgs/msg/Status", decode_jackal_status, "battery"),
    _vendor("spot_msgs/msg/BatteryStateArray", decode_spot_batteries, "battery"),
    _vendor("racepak/msg/rp_controls", decode_racepak_controls, "intervention"),
    _vendor("husky_msgs/msg/HuskyStatus", decode_husky_status, "battery", "intervention"),
    _vendor("warthog_msgs/msg/Status", decode_warthog_status, "battery", "intervention"),
    _vendor("unitree_go/msg/LowState", decode_unitree_state, "imu", "joints", "battery"),
    _vendor("unitree_legged_msgs/msg/LowState", decode_unitree_state, "imu", "joints", "battery"),
    _vendor("unitree_legged_msgs/msg/HighState", decode_unitree_state, "imu", "joints", "battery"),
    _vendor("anymal_msgs/msg/AnymalState", decode_anymal_state, "joints"),
    Message("tf2_msgs/msg/TFMessage", decode_transforms, (TRANSFORMS,)),
    Message("tf/msg/tfMessage", decode_transforms, (TRANSFORMS,)),
    *_foxglove("FrameTransform", decode_foxglove_transform, proposed=(TRANSFORMS,)),
    *_foxglove("FrameTransforms", decode_foxglove_transforms, proposed=(TRANSFORMS,)),
    Message("sensor_msgs/msg/NavSatFix", decode_nav_sat_fix),
    Message("std_msgs/msg/String", decode_string),
)

MESSAGES: dict[str, Message] = {row.type: row for row in _ROWS}
"""The rows by normalised type, in the order in which a stream prefers and lists them."""


@cache
def proposed_types(stream: str) -> tuple[str, ...]:
    """The types from which a stream is proposed."""
    return tuple(row.type for row in _ROWS if stream in row.proposed)


@cache
def readable_types(stream: str) -> tuple[str, ...]:
    """Every type that a named topic of the stream may have, those that are proposed first."""
    return (*proposed_types(stream), *(row.type for row in _ROWS if stream in row.named))
