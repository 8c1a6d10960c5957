"""Which decoder reads which message type."""

from collections.abc import Callable
from typing import Any

from navtool.datasets.decode.channel_cloud import decode_channel_cloud
from navtool.datasets.decode.compressed_image import decode_compressed_image
from navtool.datasets.decode.foxglove import (
    decode_foxglove_calibration,
    decode_foxglove_compressed_image,
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

type Decoder = Callable[[Any], Decoded]

_FOXGLOVE: dict[str, Decoder] = {
    "CameraCalibration": decode_foxglove_calibration,
    "CompressedImage": decode_foxglove_compressed_image,
    "FrameTransform": decode_foxglove_transform,
    "FrameTransforms": decode_foxglove_transforms,
    "PointCloud": decode_foxglove_point_cloud,
    "PoseInFrame": decode_foxglove_pose,
    "RawImage": decode_foxglove_raw_image,
}

VENDOR_DECODERS: dict[str, Decoder] = {
    "anymal_msgs/msg/AnymalState": decode_anymal_state,
    "anymal_msgs/msg/BatteryState": decode_anymal_battery,
    "clearpath_platform_msgs/msg/Power": decode_clearpath_power,
    "husky_msgs/msg/HuskyStatus": decode_husky_status,
    "jackal_msgs/msg/Status": decode_jackal_status,
    "racepak/msg/rp_controls": decode_racepak_controls,
    "spot_msgs/msg/BatteryStateArray": decode_spot_batteries,
    "unitree_go/msg/LowState": decode_unitree_state,
    "unitree_go/msg/SportModeState": decode_unitree_sport_state,
    "unitree_legged_msgs/msg/HighState": decode_unitree_state,
    "unitree_legged_msgs/msg/LowState": decode_unitree_state,
    "warthog_msgs/msg/Status": decode_warthog_status,
}
"""Types that only the recording itself defines."""

DECODERS: dict[str, Decoder] = {
    **VENDOR_DECODERS,
    **{f"foxglove.{name}": decoder for name, decoder in _FOXGLOVE.items()},
    **{f"foxglove_msgs/msg/{name}": decoder for name, decoder in _FOXGLOVE.items()},
    "geometry_msgs/msg/PoseStamped": decode_pose_stamped,
    "geometry_msgs/msg/PoseWithCovarianceStamped": decode_pose_with_covariance_stamped,
    "geometry_msgs/msg/Twist": decode_twist,
    "geometry_msgs/msg/TwistStamped": decode_twist_stamped,
    "geometry_msgs/msg/TwistWithCovarianceStamped": decode_twist_with_covariance_stamped,
    "livox_interfaces/msg/CustomMsg": decode_livox,
    "livox_ros_driver/msg/CustomMsg": decode_livox,
    "livox_ros_driver2/msg/CustomMsg": decode_livox,
    "nav_msgs/msg/Odometry": decode_odometry,
    "sensor_msgs/msg/BatteryState": decode_battery_state,
    "sensor_msgs/msg/CameraInfo": decode_camera_info,
    "sensor_msgs/msg/CompressedImage": decode_compressed_image,
    "sensor_msgs/msg/Image": decode_image,
    "sensor_msgs/msg/Imu": decode_imu,
    "sensor_msgs/msg/JointState": decode_joint_state,
    "sensor_msgs/msg/Joy": decode_joy,
    "sensor_msgs/msg/LaserScan": decode_laser_scan,
    "sensor_msgs/msg/NavSatFix": decode_nav_sat_fix,
    "sensor_msgs/msg/PointCloud": decode_channel_cloud,
    "sensor_msgs/msg/PointCloud2": decode_point_cloud,
    "std_msgs/msg/Bool": decode_bool,
    "std_msgs/msg/Float32": decode_float,
    "std_msgs/msg/Float64": decode_float,
    "std_msgs/msg/String": decode_string,
    "velodyne_msgs/msg/VelodyneScan": decode_velodyne_scan,
    "tf/msg/tfMessage": decode_transforms,
    "tf2_msgs/msg/TFMessage": decode_transforms,
}
"""By normalised type; the message it takes is an object with the fields of the type's definition."""
