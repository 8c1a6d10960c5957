"""The decoded messages: what navtool works with once a recording's bytes are understood.

Every class carries the header's stamp and frame. A message without a header (``geometry_msgs/Twist``, ``std_msgs/*``)
has ``stamp_ns`` None and an empty ``frame_id``; a header that was never filled in has ``stamp_ns`` 0, as recorded.
Units are SI and axes as recorded (REP-103); quaternions are xyzw. Large arrays may be read-only views of the message.
"""

from dataclasses import dataclass, field

from jaxtyping import Float32, Float64, UInt8, UInt16

from navtool.base.note import Note
from navtool.base.plain import LEFT_OUT_WHILE_EMPTY
from navtool.datasets.decode.levels import Deep
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.camera import CameraModel


@dataclass(frozen=True, kw_only=True)
class ImageFrame:
    """A colour image, whatever its encoding was: a grey one has three equal channels."""

    stamp_ns: int | None
    frame_id: str
    rgb: UInt8[Array, "h w 3"]
    encoding: str
    """The encoding as recorded, such as ``bayer_rggb8``, or the compression, such as ``jpeg``."""
    notes: tuple[Note, ...] = ()
    """What is odd about the message: numbers or names that were not believed, and what was done instead."""
    deep: Deep | None = None
    """Its samples of 16 bits, of which ``rgb`` has the upper ones; None where it has 8."""
    exchanged: bool = False
    """Whether red and blue were exchanged, since the message says that the compressed picture has them so."""


@dataclass(frozen=True, kw_only=True)
class VideoPacket:
    """A packet of a video, whose picture may need those before it; `navtool.datasets.decode.video_decoder` has them."""

    stamp_ns: int | None
    frame_id: str
    codec: str
    """``h264``, ``hevc``, ``av1``, ``vp9``, ``vp8``, ``mpeg4`` or ``mjpeg``."""
    data: bytes
    key: bool
    """Whether decoding can begin with it, given the parameter sets."""
    parameters: bytes = b""
    """Parameter sets that it brings along; without them a decoder does not begin."""
    sps: bytes = b""
    slice_head: bytes = b""
    """Sequence parameter set and beginning of the first slice (H.264), which tell whether packets are missing."""


@dataclass(frozen=True, kw_only=True)
class PointCloud:
    """The points of a LiDAR's or planar scanner's sweep in the sensor's frame, in the order they were recorded."""

    stamp_ns: int | None
    frame_id: str
    xyz: Float32[Array, "n 3"]
    """Metres; every coordinate is finite. A missing return that was recorded as zeros is still there."""
    intensity: Float32[Array, " n"] | None
    """As recorded, in the sensor's own scale; None where the cloud has no such field."""
    ring: UInt16[Array, " n"] | None
    """Index of the laser; None where the cloud has no such field."""
    time_s: Float32[Array, " n"] | None
    """Seconds relative to the header stamp, negative where the header marks the end of the sweep."""
    dropped_nonfinite: int
    """Points left out because a coordinate was NaN or infinite; beams recorded as ranges without a return are none."""
    notes: tuple[Note, ...] = ()
    """What is odd about the message: numbers that were not believed, and what was done instead."""


@dataclass(frozen=True, kw_only=True)
class OdometrySample:
    """Pose of the child frame in ``frame_id``, and its velocity in the child frame."""

    stamp_ns: int | None
    frame_id: str
    child_frame_id: str
    position: Float64[Array, " 3"]
    orientation: Float64[Array, " 4"]
    linear: Float64[Array, " 3"]
    angular: Float64[Array, " 3"]


@dataclass(frozen=True, kw_only=True)
class PoseSample:
    """A pose in ``frame_id``."""

    stamp_ns: int | None
    frame_id: str
    position: Float64[Array, " 3"]
    orientation: Float64[Array, " 4"]


@dataclass(frozen=True, kw_only=True)
class ImuSample:
    """One reading of an inertial sensor, in the sensor's axes."""

    stamp_ns: int | None
    frame_id: str
    angular_velocity: Float64[Array, " 3"]
    linear_acceleration: Float64[Array, " 3"]
    orientation: Float64[Array, " 4"] | None
    """None where the driver declares that it estimates none (first covariance -1)."""


@dataclass(frozen=True, kw_only=True)
class JointSample:
    """Joint states, one row a joint; what the message left out is NaN, and so is what it recorded as NaN."""

    stamp_ns: int | None
    frame_id: str
    names: tuple[str, ...]
    """Empty strings for values that the message did not name."""
    position: Float64[Array, " n"]
    velocity: Float64[Array, " n"]
    effort: Float64[Array, " n"]


@dataclass(frozen=True, kw_only=True)
class BatterySample:
    """Battery readings; NaN where the driver does not measure one."""

    stamp_ns: int | None
    frame_id: str
    current_a: float
    """Positive while charging, by the message's definition."""
    voltage_v: float
    percentage: float
    """Charge in 0..1."""


@dataclass(frozen=True, kw_only=True)
class TwistSample:
    """A velocity, commanded or measured."""

    stamp_ns: int | None
    frame_id: str
    linear: Float64[Array, " 3"]
    angular: Float64[Array, " 3"]


@dataclass(frozen=True, kw_only=True)
class Region:
    """The part of a sensor that is read out, in pixels of the whole sensor, and how its pixels are put together."""

    offset: tuple[int, int] = (0, 0)
    """Columns and rows left of it and above it."""
    size: tuple[int, int] = (0, 0)
    """Width and height; zeros for the whole sensor."""
    binning: tuple[int, int] = (1, 1)
    """Columns and rows that make one pixel of the picture."""

    def __bool__(self) -> bool:
        """Whether the picture is another one than the whole sensor's."""
        return any(self.size) or self.binning != (1, 1)


@dataclass(frozen=True, kw_only=True)
class CameraInfoSample:
    """A calibrated camera, with its rectification."""

    stamp_ns: int | None
    frame_id: str
    camera: CameraModel
    rectification: Float64[Array, "3 3"]
    """R: rotation from the camera's frame to the rectified one."""
    projection: Float64[Array, "3 4"]
    """P: projection of the rectified image."""
    region: Region = field(default=Region(), metadata=LEFT_OUT_WHILE_EMPTY)
    """The part of the sensor that the pictures show; camera, R and P are those of the whole sensor."""
    told: str = field(default="", metadata=LEFT_OUT_WHILE_EMPTY)
    """What was made of a lens whose name and coefficients disagree."""


@dataclass(frozen=True, kw_only=True)
class Transform:
    """Pose of the child frame in the parent frame: ``p_parent = matrix @ p_child``."""

    parent: str
    child: str
    stamp_ns: int
    matrix: Float64[Array, "4 4"]


@dataclass(frozen=True, kw_only=True)
class TransformsSample:
    """The transforms of one message; each has its own stamp, so the message has none."""

    stamp_ns: int | None
    frame_id: str
    transforms: tuple[Transform, ...]


@dataclass(frozen=True, kw_only=True)
class NavSatSample:
    """A satellite fix in WGS 84."""

    stamp_ns: int | None
    frame_id: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    has_fix: bool


@dataclass(frozen=True, kw_only=True)
class BoolSample:
    """A flag, such as an emergency stop."""

    stamp_ns: int | None
    frame_id: str
    value: bool


@dataclass(frozen=True, kw_only=True)
class FloatSample:
    """A number, such as a battery current."""

    stamp_ns: int | None
    frame_id: str
    value: float


@dataclass(frozen=True, kw_only=True)
class JoySample:
    """A joystick: axes in [-1, 1], buttons 0 or 1, in the driver's order."""

    stamp_ns: int | None
    frame_id: str
    axes: Float64[Array, " a"]
    buttons: Float64[Array, " b"]


@dataclass(frozen=True, kw_only=True)
class RobotStateSample:
    """Several of a robot's streams in one message, by their names; None where the message's layout lacks one."""

    stamp_ns: int | None
    frame_id: str
    joints: JointSample | None = None
    imu: ImuSample | None = None
    battery: BatterySample | None = None
    intervention: BoolSample | None = None


@dataclass(frozen=True, kw_only=True)
class StringSample:
    """A text, such as a robot description."""

    stamp_ns: int | None
    frame_id: str
    value: str


type Decoded = (
    ImageFrame
    | VideoPacket
    | PointCloud
    | OdometrySample
    | PoseSample
    | ImuSample
    | JointSample
    | BatterySample
    | TwistSample
    | CameraInfoSample
    | TransformsSample
    | NavSatSample
    | BoolSample
    | FloatSample
    | JoySample
    | RobotStateSample
    | StringSample
)
"""Whatever a message decodes to."""
