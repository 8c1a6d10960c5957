"""A camera: its shutter, sensor and lens."""

import math
from dataclasses import dataclass

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse


@dataclass(kw_only=True, slots=True)
class CameraConfig:
    """How light becomes grey levels; the defaults are a small global-shutter camera at f/2 with 3 um pixels."""

    shutter_s: float | None = None
    """Exposure time, in (0, 1]; None lets the camera choose for each picture."""
    longest_shutter_s: float = 1 / 30
    """Longest exposure that the camera chooses, in (0, 1]."""
    shortest_shutter_s: float = 1 / 8000
    """Shortest exposure that it chooses, above 0."""
    largest_gain: float = 16.0
    """Largest amplification, at least 1 (24 dB is 16): chosen once the longest exposure is too dark."""
    target: float = 0.18
    """Mean linear brightness that the camera aims at, as a share of saturation, in (0, 1)."""
    electrons_per_lux_s: float = 800.0
    """Electrons in a pixel that looks at a white sheet under 1 lux for 1 s: f/2, 9 um2, half of it lost in the colour
    filter, and half of the rest not converted."""
    full_well: float = 10_000.0
    """Electrons at which a pixel saturates."""
    read_noise: float = 3.0
    """Standard deviation of the read-out in electrons, at least 0."""
    blur_px: float = 0.5
    """Standard deviation of the lens's own blur in pixels, at least 0."""
    vignetting: float = 0.6
    """1 for the natural fall-off of brightness towards the corners (cos^4), 0 for none."""
    dirt_share: float = 0.0
    """Share of the picture that dirt on the lens covers, 0 to 1."""
    edge_rays: int = 1
    """Further rays for each pixel with leaves or blades near by, 0 to 8: a blade of grass is thinner than a pixel."""
    blur_poses: int = 9
    """Moments during the exposure at which the camera's pose is taken, 2 to 33."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 1, "shortest_shutter_s", "longest_shutter_s", "shutter_s", unit="s", above=True),
            fault(
                "shortest_shutter_s",
                f"{self.shortest_shutter_s} s is above longest_shutter_s = {self.longest_shutter_s} s",
                when=self.shortest_shutter_s > self.longest_shutter_s,
            ),
            outside(self, 1, math.inf, "largest_gain"),
            outside(self, 0, 1, "target", above=True, below=True),
            outside(self, 0, math.inf, "electrons_per_lux_s", "full_well", above=True),
            outside(self, 0, math.inf, "read_noise", "blur_px"),
            outside(self, 0, 1, "dirt_share", "vignetting"),
            outside(self, 2, 33, "blur_poses"),
            outside(self, 0, 8, "edge_rays"),
        )
