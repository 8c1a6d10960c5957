"""The camera on a robot, and what becomes of its messages on the way to the recording."""

import math
from dataclasses import dataclass, field

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.pipeline.geometry.camera import CameraModel
from navtool.sim.sensors.camera_config import CameraConfig


@dataclass(kw_only=True, slots=True)
class CameraSetup:
    """The front camera."""

    width: int = 320
    """Width of its picture in pixels, 32 to 1920."""
    height: int = 240
    """Height of its picture in pixels, 24 to 1440."""
    hz: float = 10.0
    """Pictures a second, in [1, 60]."""
    field_of_view_rad: float = 1.5
    """From the left edge to the right without distortion, in [0.3, 2]."""
    distortion: list[float] = field(default_factory=lambda: [-0.28, 0.07, 0.0005, -0.0003, 0.0])
    """k1, k2, p1, p2, k3 of the lens (plumb_bob); empty for none."""
    jpeg_quality: int = 88
    """Quality of the recorded pictures, 1-100."""
    sensor: CameraConfig = field(default_factory=CameraConfig)
    """Shutter, noise and dirt."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 32, 1920, "width", unit="px"),
            outside(self, 24, 1440, "height", unit="px"),
            outside(self, 1, 60, "hz", unit="Hz"),
            outside(self, 0.3, 2, "field_of_view_rad", unit="rad"),
            fault(
                "distortion",
                f"{self.distortion} are not 0, 4 or 5 coefficients",
                "give k1, k2, p1, p2, k3",
                when=len(self.distortion) not in {0, 4, 5},
            ),
            outside(self, 1, 100, "jpeg_quality"),
        )

    def model(self) -> CameraModel:
        """The calibration of this camera."""
        focal = self.width / 2 / math.tan(self.field_of_view_rad / 2)
        middle = (self.width - 1) / 2, (self.height - 1) / 2
        lens = tuple(self.distortion) or (0.0,) * 5
        return CameraModel(self.width, self.height, focal, focal, *middle, "plumb_bob", lens)


@dataclass(kw_only=True, slots=True)
class RecorderConfig:
    """Jitter, losses and delays between the sensors and the recording."""

    jitter_s: float = 0.002
    """Standard deviation of the moments at which pictures are taken, about regular ones; 0 to 0.02."""
    drop_share: float = 0.01
    """Share of the pictures and clouds that never reach the recording, 0 to 0.5."""
    delay: float = 1.0
    """How late messages reach the recorder, as a multiple of what is usual (an IMU's sample 1.5 ms, a cloud 4 ms, a
    picture 18 ms, and a third more now and then); 0 to 20."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 0.02, "jitter_s", unit="s"),
            outside(self, 0, 0.5, "drop_share"),
            outside(self, 0, 20, "delay"),
        )
