"""What a robot file says of one sensor: its topics, its pose, its lens, how its pictures are shown."""

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float64

from navtool.base.plain import LEFT_OUT_WHILE_EMPTY
from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, refuse
from navtool.datasets.decode.levels import Levels
from navtool.datasets.decode.picture_view import Colours, PictureView
from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.distortion import LENS_MODELS
from navtool.pipeline.geometry.lens_names import lens_of
from navtool.pipeline.geometry.transforms import transform_from_xyz_rpy

_MOST_SAMPLE = 65_535
NO_TOPIC = "none"
"""As the only candidate of a stream: the robot's recordings have this topic, but it is not wanted."""


def empty_name(key: str, names: list[str]) -> list[Fault]:
    """The fault of topics among which one has no name."""
    empty = any(not name.strip("/ ") for name in names)
    return fault(key, f"an empty topic name in {names}", "remove it, or name a topic", when=empty)


@dataclass(kw_only=True, slots=True)
class CameraFallback:
    """Calibration of a camera, for recordings that have no CameraInfo of it."""

    width: int
    """Width of the calibrated image in pixels."""
    height: int
    """Height of the calibrated image in pixels."""
    fx: float
    """Focal length along columns in pixels."""
    fy: float
    """Focal length along rows in pixels."""
    cx: float
    """Principal point's column in pixels."""
    cy: float
    """Principal point's row in pixels."""
    distortion_model: str = "none"
    """none, plumb_bob, rational_polynomial or equidistant, or as a driver spells them."""
    distortion: list[float] = field(default_factory=list)
    """Coefficients in OpenCV's order; plumb_bob and rational_polynomial 4 to 14, equidistant 4."""
    overrule: bool = field(default=False, metadata=LEFT_OUT_WHILE_EMPTY)
    """Whether it counts although the recording has a CameraInfo, which is wrong."""

    def __post_init__(self) -> None:
        pixels = ("width", "height", "fx", "fy")
        calibrated = "give it in pixels of the calibrated image"
        refuse(
            outside(self, 0, math.inf, *pixels, unit="px", above=True, below=True, cure=calibrated),
            _lens_fault(self.distortion_model, self.distortion),
        )


def _lens_fault(model: str, coefficients: list[float]) -> list[Fault]:
    """What is wrong with a lens as a robot file describes it."""
    if not all(map(math.isfinite, coefficients)):
        return [Fault("distortion", f"{coefficients} are not finite numbers", "give the lens's coefficients")]
    try:
        told = lens_of(model, tuple(coefficients)).told
    except ValueError as error:
        if "coefficients; expected" in str(error):
            return [Fault("distortion", f"{coefficients}: {error}", "give as many as the model has")]
        known = ", ".join(LENS_MODELS)
        return [Fault("distortion_model", f"there is no distortion model {model!r}", f"use one of {known}")]
    return [Fault("distortion", f"{coefficients}: {told}", "name the lens model of these coefficients")] if told else []


@dataclass(kw_only=True, slots=True)
class Mounting:
    """Pose of a sensor's frame in the base frame, for recordings whose tf has no path between them."""

    xyz_m: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Position in the base frame: forward, left, up."""
    rpy_rad: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    """Roll, pitch, yaw about the base's fixed axes; of the optical frame (z forward, x right) for the camera."""
    overrule: bool = field(default=False, metadata=LEFT_OUT_WHILE_EMPTY)
    """Whether it counts although the recording's tf has a pose, which is wrong."""

    def __post_init__(self) -> None:
        for name, unit in (("xyz_m", "metres"), ("rpy_rad", "radians")):
            values: list[float] = getattr(self, name)
            three = len(values) == 3 and all(map(math.isfinite, values))
            refuse(
                fault(name, f"{values} are not three finite numbers", f"give three numbers in {unit}", when=not three)
            )
        turned = any(abs(value) > 2 * math.pi for value in self.rpy_rad)
        refuse(
            fault("rpy_rad", f"{self.rpy_rad} rad is more than a full turn", "give radians, not degrees", when=turned),
        )

    def pose(self) -> Float64[Array, "4 4"]:
        """As a matrix: p_base = M p_sensor."""
        return transform_from_xyz_rpy(np.array(self.xyz_m), np.array(self.rpy_rad))


@dataclass(kw_only=True, slots=True)
class PictureSettings:
    """How a camera's pictures are shown, where a recording's own first seconds and its formats are not to say it."""

    range: list[int] = field(default_factory=list)
    """Samples of 16-bit pictures that become black and white, 0 to 65535; empty goes by a recording's first seconds."""
    colours: Colours = Colours.auto
    """auto goes by encodings and formats; as_held takes compressed pictures as the files have them; exchanged exchanges
    red and blue."""

    def __post_init__(self) -> None:
        two = len(self.range) == 2 and 0 <= self.range[0] < self.range[1] <= _MOST_SAMPLE
        what = f"{self.range} are not two numbers of 0 to {_MOST_SAMPLE}, the smaller one in front"
        refuse(fault("range", what, "give black and white", when=bool(self.range) and not two))

    def view(self, levels: Levels) -> PictureView:
        """How pictures are shown that would be shown at these levels."""
        return PictureView(Levels(*self.range) if self.range else levels, self.colours)


@dataclass(kw_only=True, slots=True)
class FurtherSensor:
    """A sensor beside the first one of its kind."""

    topics: list[str]
    """Candidate topics, best first; it is never proposed."""
    mounting: Mounting | None = None
    """Pose where tf has no path to the base frame."""
    frame: str = field(default="", metadata=LEFT_OUT_WHILE_EMPTY)
    """Its frame, where several sensors publish on its topic; empty takes the one with most messages."""

    def __post_init__(self) -> None:
        without = not self.topics or NO_TOPIC in self.topics
        refuse(
            fault("topics", f"{self.topics} names no topic", "name its topic, or remove the sensor", when=without),
            empty_name("topics", self.topics),
        )


@dataclass(kw_only=True, slots=True)
class FurtherCamera(FurtherSensor):
    """A camera beside the front camera."""

    camera_info: list[str] = field(default_factory=list)
    """Candidate topics of its CameraInfo; empty takes the one in its images' namespace."""
    calibration: CameraFallback | None = None
    """Calibration where a recording has none of this camera."""


@dataclass(kw_only=True, slots=True)
class FurtherLidar(FurtherSensor):
    """A LiDAR beside the first one; its clouds are kept whole, beside the rows."""
