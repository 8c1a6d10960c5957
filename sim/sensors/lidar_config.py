"""A spinning LiDAR: where its lasers point, when they fire, and what its receiver detects."""

import math
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import pairwise

import numpy as np
from jaxtyping import Float, Float32, Int

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array


class Returns(StrEnum):
    """Which echoes of a beam become points."""

    strongest = "strongest"
    last = "last"
    dual = "dual"
    """The strongest and the last; where they are one, the strongest and the second strongest."""


@dataclass(kw_only=True, slots=True)
class LidarConfig:
    """Geometry, timing and receiver; the defaults are a Velodyne VLP-16.

    Angles and times are those of the VLP-16's manual (revision D), the divergence that of the VLS-128's, its sister.
    Aperture, ``ten_percent_range_m``, ``full_scale``, ``pulse_m``, ``focus_m`` and the noise are chosen.
    """

    elevation_rad: list[float] = field(default_factory=lambda: np.radians(np.arange(-15.0, 16.0, 2.0)).tolist())
    """Elevation of each laser from the lowest up: ring 0 is the lowest."""
    firing_order: list[int] = field(default_factory=lambda: [k // 2 + 8 * (k % 2) for k in range(16)])
    """Rings in the order in which they fire."""
    laser_period_s: float = 2.304e-6
    """Between two lasers of one firing."""
    firing_period_s: float = 55.296e-6
    """Between two firings of all lasers."""
    rate_hz: float = 10.0
    """Turns a second, in [5, 20]."""
    divergence_rad: list[float] = field(default_factory=lambda: [3.0e-3, 1.5e-3])
    """Full angle by which a beam widens, across and up."""
    aperture_m: list[float] = field(default_factory=lambda: [0.0127, 0.0095])
    """Width and height of a beam where it leaves the sensor."""
    min_range_m: float = 0.5
    """The receiver is blind below."""
    max_range_m: float = 100.0
    """The receiver stops listening beyond."""
    ten_percent_range_m: float = 50.0
    """A plate of 10 % reflectivity that fills the beam is detected up to here: this sets the faintest echo."""
    focus_m: float = 8.0
    """Nearer than this the receiver looks past part of the beam's spot: an echo has to be as strong as at this range to
    be detected. Chosen: without it, each rain drop close to the sensor would be a point."""
    full_scale: float = 0.28
    """Reflectivity of a plate facing the sensor that returns the highest intensity, 255; what is brighter saturates.
    0.28 makes walls, trunks and boulders saturate, as MIM's solid obstacles do (> 0.75 R). 2.55 is the linear scale
    of Velodyne's own calibration, 100 for a white Lambertian plate."""
    pulse_m: float = 0.3
    """Standard deviation of the received pulse, as a range: echoes closer than that add up. A pulse of 5 ns."""
    echo_gap_m: float = 1.0
    """Echoes closer than this are one."""
    range_noise_m: float = 0.02
    """Standard deviation of the range of a strong echo; an echo at the detection limit has twice as much."""
    range_step_m: float = 0.002
    """Ranges are whole multiples of it."""
    returns: Returns = Returns.strongest
    """Which echoes become points."""

    def __post_init__(self) -> None:
        lasers = len(self.elevation_rad)
        above = ("ten_percent_range_m", "full_scale", "pulse_m", "echo_gap_m", "range_step_m")
        rises = all(a < b for a, b in pairwise(self.elevation_rad))
        refuse(
            fault(
                "firing_order",
                f"{self.firing_order} does not name each of the {lasers} rings once",
                when=not lasers or sorted(self.firing_order) != list(range(lasers)),
            ),
            fault("elevation_rad", f"{self.elevation_rad} does not rise from ring to ring", when=not rises),
            fault(
                "laser_period_s",
                f"{lasers} lasers at {self.laser_period_s} s do not fit into {self.firing_period_s} s",
                when=lasers * self.laser_period_s > self.firing_period_s,
            ),
            outside(self, 5, 20, "rate_hz", unit="Hz"),
            outside(self, 0, self.max_range_m, "min_range_m", unit="m", above=True, below=True),
            outside(self, 0, math.inf, *above, above=True),
        )

    @property
    def rings(self) -> int:
        """How many lasers there are."""
        return len(self.elevation_rad)

    @property
    def columns(self) -> int:
        """How many firings a turn has."""
        return int(1 / (self.rate_hz * self.firing_period_s))

    @property
    def column_rad(self) -> float:
        """By how much the sensor turns from one firing to the next."""
        return float(2 * np.pi * self.rate_hz * self.firing_period_s)

    def faintest(self, range_m: Float32[Array, "*n"]) -> Float32[Array, "*n"]:
        """The least strength of a detected echo, relative to a white Lambertian plate, by its range."""
        reach = np.maximum(range_m, np.float32(self.focus_m)) * np.float32(1 / self.ten_percent_range_m)
        return np.asarray(np.float32(0.1) * reach * reach)

    def column_time_s(self) -> Float[Array, " columns"]:
        """When each firing begins, relative to the last laser of the last firing."""
        end = (self.columns - 1) * self.firing_period_s + (self.rings - 1) * self.laser_period_s
        return np.arange(self.columns) * self.firing_period_s - end

    def laser_time_s(self) -> Float[Array, " rings"]:
        """When each ring fires after its firing has begun."""
        return self.order() * self.laser_period_s

    def order(self) -> Int[Array, " rings"]:
        """The place of each ring within a firing."""
        return np.argsort(np.array(self.firing_order))

    def azimuth_rad(self) -> Float[Array, "rings columns"]:
        """Azimuth of each beam: clockwise seen from above, from straight ahead."""
        time = np.arange(self.columns)[None, :] * self.firing_period_s + self.laser_time_s()[:, None]
        return np.asarray(-2 * np.pi * self.rate_hz * time)
