"""A camera: its shutter, sensor and lens."""

from dataclasses import dataclass


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
        shutters = [
            self.shortest_shutter_s,
            self.longest_shutter_s,
            *([] if self.shutter_s is None else [self.shutter_s]),
        ]
        if not all(0 < shutter <= 1 for shutter in shutters) or self.shortest_shutter_s > self.longest_shutter_s:
            raise ValueError(f"exposures are within (0, 1] s and the shortest comes first, got {shutters} s")
        if self.largest_gain < 1 or not 0 < self.target < 1:
            raise ValueError(f"need largest_gain >= 1 and 0 < target < 1, got {self.largest_gain} and {self.target}")
        if min(self.electrons_per_lux_s, self.full_well) <= 0 or min(self.read_noise, self.blur_px) < 0:
            raise ValueError(f"need electrons above 0, and noise and blur of at least 0, got {self}")
        if not 0 <= self.dirt_share <= 1 or not 0 <= self.vignetting <= 1 or not 2 <= self.blur_poses <= 33:
            raise ValueError(f"need dirt_share and vignetting within 0-1 and 2-33 blur_poses, got {self}")
        if not 0 <= self.edge_rays <= 8:
            raise ValueError(f"need 0-8 edge_rays, got {self.edge_rays}")
