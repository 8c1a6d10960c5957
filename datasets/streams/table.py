"""The streams of a data set: one row a stream. What reads, aligns, writes or checks streams goes by this table.

A robot's first camera and LiDAR are the streams ``camera`` and ``lidar``; further ones go by the same rows and have a
name behind a dot: ``camera.rear``, ``camera_info.rear``, ``lidar.roof``.

Which message types feed a stream is said once too, in the rows of `navtool.datasets.decode.table`.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from navtool.datasets.streams.sync import Method
from navtool.datasets.streams.topic_hints import NO_HINTS, TopicHints

FRONT = "front"
"""The first camera; what it records is the stream ``camera``."""
TWIST_COLUMNS = ("vx_mps", "vy_mps", "vz_mps", "wx_radps", "wy_radps", "wz_radps")


class Kind(StrEnum):
    """How a stream's messages are read."""

    large = "large"
    """Images and clouds: decoded in the second pass, one portion of the recording after the other."""
    small = "small"
    """Rows of numbers: decoded in the first pass and kept in full."""
    geometry = "geometry"
    """What a sensor's messages mean: read once, and part of the calibration."""


@dataclass(frozen=True, slots=True)
class DefaultSync:
    """How a stream is brought onto the grid where the settings say nothing."""

    method: Method
    tolerance_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Stream:
    """One stream: what it is called, how its topic is found, how it reaches the rows."""

    name: str
    """In settings, reports and the names of its files."""
    kind: Kind
    hints: TopicHints = NO_HINTS
    """How well a topic's name fits."""
    another: str
    """What a topic of its types is that is not used because another one is."""
    columns: tuple[str, ...] = ()
    """Values of a message at the stream's own rate; empty where the robot names them, or there are none."""
    sync: DefaultSync | None = None
    """None where it is not brought onto the grid."""
    column: str = ""
    """Its name in ``valid.*`` and ``sync.error_s.*`` where that is another; such columns are in every data set."""
    makes_grid: bool = False
    """Whether it may span the grid; of those that a recording has the first one does."""
    makes_grid_alone: bool = False
    """Whether it may span the grid of a recording in which none of those can."""
    pose: str = ""
    """The field of the calibration that holds its sensor's pose; empty where it has none to know."""
    never_still: bool = False
    """Whether its sensor never measures the same twice to the last digit while it works."""
    late_s: float = 1.0
    """How long after it was measured the least delayed message of such a sensor may be recorded, in seconds."""


_DERIVED_IMAGES = r"preview|debug|overlay|segment|mask|label|stitch|map|panorama|annotated|marker|detection"
_CAMERA_CLOUDS = r"depth|deep|stereo|realsense|zed|camera"
_DERIVED_CLOUDS = r"registered|map|undist|deskew|filter|ground|obstacle|cluster|concat|fused|merged|stitch"

_ROWS = (
    Stream(
        name="camera",
        kind=Kind.large,
        hints=TopicHints(
            weights=(
                (r"front|forward", 4),
                (r"(?<!left)(?<!right)(?<!left_)(?<!right_)(front|forward)(?!.*(left|right))", 2),
                (r"cent(er|re)", 1),
                (r"(?<!de)colou?r|rgb|hdr", 2),
                (r"left", 1),
                (r"right", -1),
                (r"rear|back|down|(?<![a-z])up|top|fourth|fifth|sixth|third", -4),
                (r"infra|mono|thermal|nir|dvs|event", -3),
                (_DERIVED_IMAGES, -5),
                (r"rect", -1),
            ),
            never=r"depth|disparity|confidence|theora",
            derived=_DERIVED_IMAGES,
        ),
        another="another camera",
        sync=DefaultSync(Method.nearest, 0.06),
        makes_grid=True,
        pose="base_camera",
        late_s=0.5,
    ),
    Stream(
        name="camera_info",
        kind=Kind.geometry,
        another="calibration of a camera that is not used",
    ),
    Stream(
        name="lidar",
        kind=Kind.large,
        hints=TopicHints(
            weights=(
                (r"points(_raw)?$|cloud$|point_?cloud2?$|pandar$", 2),
                (r"velodyne|ouster|(?<![a-z])os\d?_|hesai|pandar|livox|rslidar|robosense|lidar|vlp", 2),
                (r"front", 1),
                (r"rear|back", -2),
                (_CAMERA_CLOUDS, -5),
                (_DERIVED_CLOUDS, -4),
            ),
            derived=f"{_CAMERA_CLOUDS}|{_DERIVED_CLOUDS}",
        ),
        another="another point cloud",
        sync=DefaultSync(Method.nearest, 0.06),
        makes_grid=True,
        pose="base_lidar",
        late_s=0.4,
    ),
    Stream(
        name="odometry",
        kind=Kind.small,
        hints=TopicHints(
            weights=(
                (r"(?<![a-z])odom(etry)?$", 2),
                (r"filtered|local|fused", 3),
                (r"controller|wheel|platform|state_estimator|body", 1),
                (r"stereo|visual|vio|zed|camera|superodometry|lidar|dlio|integrated", -2),
                (r"gps|gnss|utm|global|map|rtk|navsat|inertial_explorer|ground_?truth|(?<![a-z])gt(?![a-z])|raw", -4),
                (r"action|cmd|goal|target", -6),
            ),
        ),
        another="another odometry",
        columns=("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw", *TWIST_COLUMNS),
        sync=DefaultSync(Method.linear, 0.25),
        column="state",
        makes_grid=True,
        pose="base_odometry",
        late_s=0.4,
    ),
    Stream(
        name="imu",
        kind=Kind.small,
        hints=TopicHints(
            weights=(
                (r"imu(_\d+)?/data$", 2),
                (r"raw", -1),
                (r"odom", -4),
                (r"camera|zed|realsense|d4\d\d|multisense|stereo|davis|dvs|os_cloud|os\d_|ouster|livox|velodyne", -3),
                (r"mag(?![a-z])|bias", -4),
            ),
        ),
        another="another IMU",
        columns=("ax_mps2", "ay_mps2", "az_mps2", "wx_radps", "wy_radps", "wz_radps"),
        sync=DefaultSync(Method.linear, 0.1),
        makes_grid_alone=True,
        pose="base_imu",
        never_still=True,
        late_s=0.25,
    ),
    Stream(
        name="joints",
        kind=Kind.small,
        hints=TopicHints(
            weights=(
                (r"joint_states?$", 2),
                (r"cmd|command|desired|target|goal|reference", -6),
                (r"arm|gripper|foot", -3),
            ),
        ),
        another="other joints",
        sync=DefaultSync(Method.linear, 0.1),
        makes_grid_alone=True,
        never_still=True,
        late_s=0.25,
    ),
    Stream(
        name="battery",
        kind=Kind.small,
        hints=TopicHints(weights=((r"batter|bms", 2),)),
        another="another battery",
        columns=("current_a", "voltage_v", "percentage"),
        sync=DefaultSync(Method.hold, 5.0),
        makes_grid_alone=True,
    ),
    Stream(
        name="command",
        kind=Kind.small,
        hints=TopicHints(
            weights=(
                (r"cmd_vel", 3),
                (r"controller|platform|mux|out$", 1),
                (r"joy|teleop|(?<![a-z])rc(?![a-z])|key", -2),
                (r"marker|smooth|raw|nav", -1),
            ),
            needs=r"cmd|command|desired|setpoint|reference|twist_mux|twist_in",
        ),
        another="another velocity",
        columns=TWIST_COLUMNS,
        sync=DefaultSync(Method.hold, 0.5),
        column="action",
    ),
    Stream(
        name="intervention",
        kind=Kind.small,
        hints=TopicHints(
            weights=((r"intervention", 4), (r"e_?stop|emergency", 2), (r"manual|override|takeover", 1)),
            needs=r"intervention|e_?stop|emergency|manual|override|takeover|disengage",
        ),
        another="another flag",
        columns=("active",),
    ),
)

STREAMS: dict[str, Stream] = {row.name: row for row in _ROWS}
"""The rows by name, in the order in which topics, settings and reports list them."""
SMALL = tuple(row.name for row in _ROWS if row.kind is Kind.small)
GRIDDED = tuple(row.name for row in _ROWS if row.sync is not None)
POSED = tuple(sorted((row.name for row in _ROWS if row.pose), key=lambda name: bool(STREAMS[name].column)))
"""Streams whose sensors have a pose on the robot; odometry, whose child frame it is, behind the sensors."""

SENSOR_NAME = re.compile(r"[a-z][a-z0-9_]*")
"""What a further camera or LiDAR may be called."""


def row_of(stream: str) -> Stream:
    """The row of a stream, also of a further camera's or LiDAR's.

    Raises:
        KeyError: No stream is called so.
    """
    return STREAMS[stream.partition(".")[0]]


def further(kind: str, name: str) -> str:
    """The stream of a further sensor: ``camera.rear`` of kind ``camera`` and name ``rear``."""
    return f"{kind}.{name}"


def sensor_of(stream: str) -> str:
    """The name of a further sensor's stream behind the dot; empty for a first one's."""
    return stream.partition(".")[2]


def of_kind(kind: str, streams: Iterable[str]) -> tuple[str, ...]:
    """Those of the streams that go by one row: ``camera``, ``camera.rear``."""
    return tuple(stream for stream in streams if stream.partition(".")[0] == kind)


def is_large(stream: str) -> bool:
    """Whether it is one of images or of clouds."""
    return row_of(stream).kind is Kind.large


def in_rows(stream: str) -> str:
    """A stream's name in ``valid.*`` and ``sync.error_s.*``."""
    row, sensor = row_of(stream), sensor_of(stream)
    column = row.column or row.name
    return further(column, sensor) if sensor else column


def in_order(streams: Iterable[str]) -> list[str]:
    """The streams in the order of the table, further sensors behind the first one."""
    rows = list(STREAMS)
    return sorted(streams, key=lambda stream: (rows.index(row_of(stream).name), bool(sensor_of(stream))))


def grid_streams(streams: Iterable[str]) -> list[str]:
    """Those that may span a grid, the ones that come first in front; the first that lasts for two ticks does."""
    return [stream for stream in in_order(streams) if row_of(stream).makes_grid]


def lone_grid_streams(streams: Iterable[str]) -> list[str]:
    """Those that span the grid of a recording that has none of the others, or none that lasts."""
    return [stream for stream in in_order(streams) if row_of(stream).makes_grid_alone]
