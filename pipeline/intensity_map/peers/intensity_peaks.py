"""Glass from peaks of intensity along a planar scan, in the manner of Wang and Wang (2017), "Glass-SLAM"."""

import math
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float32, Float64, Int64, UInt8

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.intensity_map.config import GridConfig
from navtool.pipeline.intensity_map.obstacles import CellClass
from navtool.pipeline.intensity_map.peers.laser_scan_map import LaserScanConfig, mark, one_ring


@dataclass(kw_only=True, slots=True)
class IntensityPeakConfig:
    """The profile of a pane in a scan."""

    scan: LaserScanConfig = field(default_factory=LaserScanConfig)
    """Which ring is the scan."""
    full_scale: float = 255.0
    """R, the largest intensity of the sensor, above 0."""
    trigger: float = 0.04
    """A peak is at least so strong, in units of R, in (0, 1]."""
    drop: float = 0.5
    """The profile falls on both sides by this share of its peak, in (0, 1); the published code uses a half."""
    width_rad: float = math.radians(20.0)
    """Within so much on either side of the peak, in (0, 1.5]."""
    incidence_rad: float = math.radians(6.0)
    """The beam of the peak meets its surface within this angle of the normal, in (0, 1.5)."""
    smooth_beams: int = 5
    """Intensities are averaged over so many neighbouring beams, odd, at least 1."""
    gap_m: float = 0.15
    """Neighbouring beams whose ranges differ by more are on different surfaces; above 0."""

    def __post_init__(self) -> None:
        even = self.smooth_beams % 2 == 0
        refuse(
            outside(self, 0, math.inf, "full_scale", "gap_m", above=True),
            outside(self, 0, 1, "trigger", above=True),
            outside(self, 0, 1, "drop", above=True, below=True),
            outside(self, 0, 1.5, "width_rad", unit="rad", above=True),
            outside(self, 0, 1.5, "incidence_rad", unit="rad", above=True, below=True),
            outside(self, 1, math.inf, "smooth_beams"),
            fault("smooth_beams", f"{self.smooth_beams} is even", "give an odd number", when=even),
        )


def intensity_peak_map(
    xyz: Float32[Array, "p 3"], intensity: Float32[Array, " p"], grid: GridConfig, config: IntensityPeakConfig
) -> UInt8[Array, "n n"]:
    """The class of each cell: transparent where a pane's profile lies, solid where the scan returns elsewhere.

    A pane mirrors the beam that meets it at a right angle: along the scan the intensity has a peak there, and falls to
    both sides, or the returns end. The published detector stands on a scanner whose panes outshine walls (its trigger
    is an absolute intensity); here the peak is held against its own flanks, so that it works on weak panes, too.

    Args:
        xyz: Points in the frame of the sensor, in metres.
        intensity: Of each point, 0 to R.
        grid: Where the cells lie.
        config: The scan and the profile.
    """
    ring = one_ring(xyz, config.scan)
    ring = ring[np.isfinite(intensity[ring])]
    x, y = xyz[ring, 0].astype(np.float64), xyz[ring, 1].astype(np.float64)
    azimuth, reach = np.arctan2(y, x), np.hypot(x, y)
    share = intensity[ring] / config.full_scale
    on_pane = np.zeros(ring.size, bool)
    for surface in _surfaces(azimuth, reach, config):
        first, last = _profile(azimuth[surface], reach[surface], share[surface].astype(np.float64), config)
        on_pane[surface[first:last]] = True
    classes = mark(xyz[ring[~on_pane]], CellClass.solid, grid)
    return np.maximum(classes, mark(xyz[ring[on_pane]], CellClass.transparent, grid))


def _surfaces(
    azimuth: Float64[Array, " k"], reach: Float64[Array, " k"], config: IntensityPeakConfig
) -> list[Int64[Array, " s"]]:
    """The beams of each connected surface, in order; the one across the back is joined."""
    if not azimuth.size:
        return []
    pitch = 2 * np.pi / config.scan.beams
    apart = np.abs(np.diff(reach, append=reach[:1])) > config.gap_m
    apart |= np.diff(azimuth, append=azimuth[:1] + 2 * np.pi) > 2.5 * pitch
    beams = np.roll(np.arange(azimuth.size), -(int(np.argmax(apart)) + 1) if apart.any() else 0)
    return np.split(beams, np.flatnonzero(apart[beams])[:-1] + 1) if apart.any() else [beams]


def _profile(
    azimuth: Float64[Array, " s"], reach: Float64[Array, " s"], share: Float64[Array, " s"], config: IntensityPeakConfig
) -> tuple[int, int]:
    """From where to where a surface shows the profile of a pane; an empty range where it does not."""
    if azimuth.size < config.smooth_beams:
        return 0, 0
    ones = np.ones(config.smooth_beams)
    smooth = np.convolve(share, ones, "same") / np.convolve(np.ones(share.size), ones, "same")
    peak = int(np.argmax(smooth))
    # across the back the azimuth wraps
    angle = np.unwrap(azimuth) - np.unwrap(azimuth)[peak]
    low = smooth <= (1 - config.drop) * smooth[peak]
    before, after = np.flatnonzero(low[:peak]), np.flatnonzero(low[peak:])
    first = int(before[-1]) + 1 if before.size else 0
    last = peak + int(after[0]) if after.size else azimuth.size
    narrow = angle[first] > -config.width_rad and angle[last - 1] < config.width_rad
    if smooth[peak] < config.trigger or not narrow or last - first < config.smooth_beams:
        return 0, 0
    # on a plane that the peak's beam meets at a right angle, the range is least there
    slope = float(np.polyfit(angle[first:last], reach[first:last], 2)[1])
    faces = abs(slope) < math.tan(config.incidence_rad) * float(reach[peak])
    return (first, last) if faces else (0, 0)
