"""How well a topic's name fits a stream, where only types and names are known."""

import re
from dataclasses import dataclass, field

_TRUTH = "/ground_truth/"
"""What a simulator knows and no sensor has measured."""
_TRANSPORTS = re.compile(r"/(compressed|compressedDepth|theora|ffmpeg|zstd)$")


def foxglove(*names: str) -> tuple[str, ...]:
    """Foxglove's types of these names, in their own schema languages and as ROS 2 messages."""
    return tuple(f"{package}{name}" for package in ("foxglove.", "foxglove_msgs/msg/") for name in names)


IMAGE_TYPES = (
    "sensor_msgs/msg/Image",
    "sensor_msgs/msg/CompressedImage",
    *foxglove("RawImage", "CompressedImage"),
)

PLANAR_TYPES = ("sensor_msgs/msg/LaserScan",)
"""Types of clouds that lie in one plane; proposed only where a recording has no other cloud."""

STREAM_TYPES: dict[str, tuple[str, ...]] = {
    "image": IMAGE_TYPES,
    "camera_info": ("sensor_msgs/msg/CameraInfo", *foxglove("CameraCalibration")),
    "lidar": (
        "sensor_msgs/msg/PointCloud2",
        "velodyne_msgs/msg/VelodyneScan",
        "livox_ros_driver/msg/CustomMsg",
        "livox_ros_driver2/msg/CustomMsg",
        "livox_interfaces/msg/CustomMsg",
        *foxglove("PointCloud"),
        *PLANAR_TYPES,
    ),
    "odometry": ("nav_msgs/msg/Odometry",),
    "imu": ("sensor_msgs/msg/Imu",),
    "joints": ("sensor_msgs/msg/JointState",),
    "battery": ("sensor_msgs/msg/BatteryState",),
    "command": ("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"),
    "intervention": ("std_msgs/msg/Bool",),
}
"""The message types that each stream can be read from, in the order of the data set's streams."""

_UNITREE = (
    "unitree_go/msg/LowState",
    "unitree_legged_msgs/msg/LowState",
    "unitree_legged_msgs/msg/HighState",
)
_STATUS_WITH_STOP = ("husky_msgs/msg/HuskyStatus", "warthog_msgs/msg/Status")

NAMED_TYPES: dict[str, tuple[str, ...]] = {
    "lidar": ("sensor_msgs/msg/PointCloud",),
    "odometry": (
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/PoseWithCovarianceStamped",
        *foxglove("PoseInFrame"),
        "unitree_go/msg/SportModeState",
    ),
    "imu": _UNITREE,
    "joints": (*_UNITREE, "anymal_msgs/msg/AnymalState"),
    "battery": (
        "std_msgs/msg/Float32",
        "std_msgs/msg/Float64",
        "anymal_msgs/msg/BatteryState",
        "clearpath_platform_msgs/msg/Power",
        "jackal_msgs/msg/Status",
        "spot_msgs/msg/BatteryStateArray",
        *_STATUS_WITH_STOP,
        *_UNITREE,
    ),
    "command": (
        "nav_msgs/msg/Odometry",
        "sensor_msgs/msg/Joy",
        "geometry_msgs/msg/TwistWithCovarianceStamped",
    ),
    "intervention": ("racepak/msg/rp_controls", *_STATUS_WITH_STOP),
}
"""Types from which a stream is read only where its topic is named: by itself such a topic may be anything."""


def readable_types(stream: str) -> tuple[str, ...]:
    """Every type that a named topic of the stream may have."""
    return (*STREAM_TYPES[stream], *NAMED_TYPES.get(stream, ()))


@dataclass(frozen=True, slots=True)
class _Hints:
    """Regular expressions on the lower-case name, with what each adds; ``never`` rules a topic out."""

    weights: tuple[tuple[str, int], ...]
    needs: str = ""
    never: str = ""
    patterns: tuple[tuple[re.Pattern[str], int], ...] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "patterns", tuple((re.compile(text), weight) for text, weight in self.weights))


_HINTS: dict[str, _Hints] = {
    "image": _Hints(
        weights=(
            (r"front|forward", 4),
            (r"(?<!de)colou?r|rgb|hdr", 2),
            (r"left", 1),
            (r"right", -1),
            (r"rear|back|down|(?<![a-z])up|top|fourth|fifth|sixth|third", -4),
            (r"infra|mono|thermal|nir|dvs|event", -3),
            (r"preview|debug|overlay|segment|mask|label|stitch|map|panorama|annotated|marker|detection", -5),
            (r"rect", -1),
        ),
        never=r"depth|disparity|confidence|theora|ffmpeg",
    ),
    "lidar": _Hints(
        weights=(
            (r"points(_raw)?$|cloud$|point_?cloud2?$|pandar$", 2),
            (r"velodyne|ouster|(?<![a-z])os\d?_|hesai|pandar|livox|rslidar|robosense|lidar|vlp", 2),
            (r"front", 1),
            (r"rear|back", -2),
            (r"depth|deep|stereo|realsense|zed|camera", -5),
            (r"registered|map|undist|deskew|filter|ground|obstacle|cluster|concat|fused|merged|stitch", -4),
        ),
    ),
    "odometry": _Hints(
        weights=(
            (r"(?<![a-z])odom(etry)?$", 2),
            (r"filtered|local|fused", 3),
            (r"controller|wheel|platform|state_estimator|body", 1),
            (r"stereo|visual|vio|zed|camera|superodometry|lidar|dlio|integrated", -2),
            (r"gps|gnss|utm|global|map|rtk|navsat|inertial_explorer|ground_?truth|(?<![a-z])gt(?![a-z])|raw", -4),
            (r"action|cmd|goal|target", -6),
        ),
    ),
    "imu": _Hints(
        weights=(
            (r"imu(_\d+)?/data$", 2),
            (r"raw", -1),
            (r"odom", -4),
            (r"camera|zed|realsense|d4\d\d|multisense|stereo|davis|dvs|os_cloud|os\d_|ouster|livox|velodyne", -3),
            (r"mag(?![a-z])|bias", -4),
        ),
    ),
    "joints": _Hints(
        weights=((r"joint_states?$", 2), (r"cmd|command|desired|target|goal|reference", -6), (r"arm|gripper|foot", -3)),
    ),
    "battery": _Hints(weights=((r"batter|bms", 2),)),
    "command": _Hints(
        weights=(
            (r"cmd_vel", 3),
            (r"controller|platform|mux|out$", 1),
            (r"joy|teleop|(?<![a-z])rc(?![a-z])|key", -2),
            (r"marker|smooth|raw|nav", -1),
        ),
        needs=r"cmd|command|desired|setpoint|reference|twist_mux|twist_in",
    ),
    "intervention": _Hints(
        weights=((r"intervention", 4), (r"e_?stop|emergency", 2), (r"manual|override|takeover", 1)),
        needs=r"intervention|e_?stop|emergency|manual|override|takeover|disengage",
    ),
}


def name_score(stream: str, name: str) -> int | None:
    """How well a topic's name fits the stream; None where it rules the topic out.

    Zero means that the name says nothing; a negative score that it hints at something else.
    """
    hints = _HINTS[stream]
    text = name.lower()
    if text.startswith(_TRUTH):
        return None
    if hints.never and re.search(hints.never, text):
        return None
    if hints.needs and not re.search(hints.needs, text):
        return None
    return sum(weight for pattern, weight in hints.patterns if pattern.search(text))


def camera_name(topic: str) -> str:
    """The image topic's name without an image transport's suffix: equal for all encodings of the same image."""
    return _TRANSPORTS.sub("", topic)


def camera_namespaces(topic: str) -> tuple[str, ...]:
    """The namespaces that may hold the image's CameraInfo, nearest first."""
    parent = camera_name(topic).rpartition("/")[0]
    return (camera_name(topic), parent)
