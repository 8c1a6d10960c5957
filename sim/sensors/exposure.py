"""From light to grey levels: shutter, gain, photon and read-out noise, saturation, tone curve."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32, UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.sensors.camera_config import CameraConfig

_CURVE_STEPS = 4096
_GRAINS = 1 << 21
"""Normal numbers drawn once; each picture takes a stretch of them that begins at random."""


class Exposure(NamedTuple):
    """What a camera has chosen for one picture."""

    shutter_s: float
    gain: float


def choose_exposure(radiance: Float32[Array, "h w 3"], illuminance_lux: float, config: CameraConfig) -> Exposure:
    """The exposure that brings the mean brightness to the target: longer first, then amplified, within the limits.

    Args:
        radiance: Light, relative to a white sheet on open ground; brighter than white counts as white, so that the
            sun's disc does not darken everything.
        illuminance_lux: What falls on open ground.
        config: The camera.
    """
    white = float(np.minimum(radiance, np.float32(1.5)).mean()) * illuminance_lux * config.electrons_per_lux_s
    wanted = config.target * config.full_well / max(white, 1e-12)
    shutter = config.shutter_s
    if shutter is None:
        shutter = min(max(wanted, config.shortest_shutter_s), config.longest_shutter_s)
    return Exposure(shutter, min(max(wanted / shutter, 1.0), config.largest_gain))


def develop(
    radiance: Float32[Array, "h w 3"],
    illuminance_lux: float,
    exposure: Exposure,
    config: CameraConfig,
    rng: np.random.Generator,
) -> UInt8[Array, "h w 3"]:
    """The picture that the sensor gives: electrons with their noise, amplified, saturated, on sRGB's tone curve."""
    electrons = radiance * np.float32(illuminance_lux * exposure.shutter_s * config.electrons_per_lux_s)
    np.minimum(electrons, np.float32(4 * config.full_well), out=electrons)
    deviation = np.sqrt(electrons + np.float32(config.read_noise**2))
    begin = int(rng.integers(0, _GRAINS))
    deviation *= np.take(_grain(), np.arange(begin, begin + deviation.size), mode="wrap").reshape(deviation.shape)
    electrons += deviation
    np.clip(electrons, 0, np.float32(config.full_well), out=electrons)
    electrons *= np.float32(exposure.gain * (_CURVE_STEPS - 1) / config.full_well)
    np.minimum(electrons, np.float32(_CURVE_STEPS - 1), out=electrons)
    return np.take(_tone_curve(), electrons.astype(np.int32))


@lru_cache(maxsize=1)
def _grain() -> Float32[Array, " grains"]:
    return np.random.default_rng(_GRAINS).standard_normal(_GRAINS, dtype=np.float32)


@lru_cache(maxsize=1)
def _tone_curve() -> UInt8[Array, " steps"]:
    linear = np.arange(_CURVE_STEPS) / (_CURVE_STEPS - 1)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return np.round(255 * encoded).astype(np.uint8)
