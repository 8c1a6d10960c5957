"""What is in the air takes light out of a beam and sends some of it back."""

import numpy as np
from jaxtyping import Float32

from navtool.pipeline.arrays import Array
from navtool.sim.world.scenario import WeatherConfig

_DECIBEL = float(np.log(10) / 10)
_DROPS_PER_M3 = 250.0
"""Drops larger than 1 mm in rain of 10 mm/h, by Marshall and Palmer's size distribution."""
_DROP_M2 = 1.8e-6
"""Cross-section of a drop of 1.5 mm."""
_DROP_REFLECTIVITY = 0.3
"""Reflectivity of a drop, seen from the light source: chosen; drops are lenses, brighter than their mirrored 2 %."""
_DUST_LIDAR_RATIO_SR = 40.0
"""Extinction over backscatter of mineral dust, a typical figure of aerosol LiDAR."""
_DUST_NEAR_M = 1.5
"""Scale of the distance at which a swirl of dust is dense enough to be seen."""


def extinction_per_m(weather: WeatherConfig) -> float:
    """Share of the light lost per metre; rain by Carbonneau's 1.076 R^0.67 dB a kilometre (ITU-R P.1814)."""
    rain = 1.076 * weather.rain_mmph**0.67 * _DECIBEL / 1000.0
    return float(rain + weather.dust_per_m)


def scattered_back(
    weather: WeatherConfig,
    count: int,
    min_range_m: float,
    beam_m2: tuple[float, float],
    pulse_m: float,
    rng: np.random.Generator,
) -> tuple[Float32[Array, "count 2"], Float32[Array, "count 2"]]:
    """Range and strength of a rain drop and of a swirl of dust in each of so many beams.

    Args:
        weather: What is in the air; without rain or dust its range is infinite.
        count: How many beams.
        min_range_m: Nothing nearer matters.
        beam_m2: Cross-section of a beam at the sensor, and its root's growth: area = (sqrt(a) + b r)^2.
        pulse_m: Standard deviation of the pulse.
        rng: Source of where the drops and swirls are.
    """
    reach = np.full((count, 2), np.inf, np.float32)
    strength = np.zeros((count, 2), np.float32)
    if weather.rain_mmph > 0:
        near_m2, growth = beam_m2
        drops = _DROPS_PER_M3 * (weather.rain_mmph / 10.0) ** 0.6
        distance = min_range_m + rng.exponential(1 / (drops * (np.sqrt(near_m2) + 3.0 * growth) ** 2), count)
        area = (np.sqrt(near_m2) + growth * distance) ** 2
        share = np.minimum(_DROP_M2 * rng.exponential(1.0, count) / area, 1.0)
        reach[:, 0], strength[:, 0] = distance, _DROP_REFLECTIVITY * share
    if weather.dust_per_m > 0:
        distance = min_range_m + rng.exponential(_DUST_NEAR_M, count)
        backscatter = np.pi * weather.dust_per_m / _DUST_LIDAR_RATIO_SR * np.sqrt(2 * np.pi) * pulse_m
        reach[:, 1], strength[:, 1] = distance, backscatter * rng.exponential(1.0, count)
    return reach, strength
