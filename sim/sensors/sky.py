"""What a camera sees where nothing stands: sky, clouds, the sun, and far trees along the horizon."""

import cv2
import numpy as np
from jaxtyping import Float, Float32

from navtool.pipeline.arrays import Array
from navtool.sim.world.randomness import Purpose, generator
from navtool.sim.world.scenario import LightConfig

_ZENITH = np.array([0.22, 0.36, 0.70], np.float32)
_HORIZON = np.array([0.72, 0.78, 0.84], np.float32)
_CLOUD = np.array([0.95, 0.95, 0.97], np.float32)
_FAR_TREES = np.array([0.075, 0.105, 0.075], np.float32)
_BRIGHTNESS = np.float32(0.6)
_CLOUD_PX = 256
_ROWS, _COLUMNS = 540, 2400
_LOWEST_RAD = -0.05
"""Elevation at which the painting begins; below lies ground wherever a camera looks."""
_SUN_COSINE = 0.99998
"""Cosine of the angle within which the sun's disc lies: 0.36 degrees, a little larger than the real one."""


class Sky:
    """The sky over a place, in units of the brightness of a white sheet on open ground; painted once."""

    def __init__(self, place: str, seed: int, sun: tuple[float, float, float], light: LightConfig) -> None:
        """Paint the sky of a place, by its name and number."""
        rng = generator(place, seed, Purpose.SKY)
        azimuth = (np.arange(_COLUMNS) + 0.5) * (2 * np.pi / _COLUMNS) - np.pi
        slope = np.tan((np.arange(_ROWS) + 0.5) / _ROWS * (np.pi / 2 - _LOWEST_RAD) + _LOWEST_RAD)
        rays = np.empty((_ROWS, _COLUMNS, 3), np.float32)
        rays[..., 0], rays[..., 1], rays[..., 2] = np.cos(azimuth), np.sin(azimuth), slope[:, None]
        rays /= np.linalg.norm(rays, axis=-1, keepdims=True)
        painted = _clear_sky(rays, np.array(sun, np.float32), light, _clouds(light, rng))
        self._picture: Array = np.ascontiguousarray(_with_far_trees(painted, slope, rng).reshape(-1, 3))

    @property
    def horizon(self) -> Float32[Array, "3"]:
        """The colour into which everything far away fades."""
        return np.asarray(_HORIZON * _BRIGHTNESS)

    def radiance(self, rays: Float32[Array, "3 n"]) -> Float32[Array, "3 n"]:
        """The light that comes along rays of any length."""
        flat = np.sqrt(rays[0] * rays[0] + rays[1] * rays[1])
        elevation = np.arctan2(rays[2], flat) - np.float32(_LOWEST_RAD)
        row = np.clip(elevation * np.float32(_ROWS / (np.pi / 2 - _LOWEST_RAD)), 0, _ROWS - 1).astype(np.int32)
        azimuth = np.arctan2(rays[1], rays[0]) + np.float32(np.pi)
        column = np.minimum((azimuth * np.float32(_COLUMNS / (2 * np.pi))).astype(np.int32), _COLUMNS - 1)
        return np.ascontiguousarray(self._picture[row * _COLUMNS + column].T)


def _clouds(light: LightConfig, rng: np.random.Generator) -> Float32[Array, "h w"]:
    """How dense the clouds are on a square that repeats: few under a bright sun, everywhere without one."""
    octaves = [
        cv2.resize(rng.standard_normal((n, n)), (_CLOUD_PX, _CLOUD_PX)) / k for k, n in enumerate((6, 14, 34, 80), 1)
    ]
    clouds = np.sum(octaves, axis=0)
    edge = np.quantile(clouds, 0.9 * light.sun_share)
    return np.asarray(np.clip((clouds - edge) * 0.8 + 0.1, 0, 1), np.float32)


def _clear_sky(
    rays: Float32[Array, "h w 3"], sun: Float32[Array, "3"], light: LightConfig, clouds: Float32[Array, "k k"]
) -> Float32[Array, "h w 3"]:
    """Blue that pales towards the horizon, clouds, and the glare of the sun."""
    up = np.clip(rays[..., 2], 0, 1)
    colour = _HORIZON + np.sqrt(up)[..., None] * (_ZENITH - _HORIZON)
    flat = np.maximum(up, np.float32(0.05))
    column, row = ((rays[..., axis] / flat * 18 + 400).astype(np.int32) % _CLOUD_PX for axis in (0, 1))
    share = clouds[row, column] * np.clip((up - np.float32(0.02)) * 6, 0, 1)
    colour += share[..., None] * (_CLOUD - colour)
    near = np.clip(rays @ sun, 0, 1)
    glare = 0.25 * near**8 + 1.5 * near**200 + 400.0 * (near > _SUN_COSINE)
    colour += (light.sun_share * glare * (1 - 0.7 * share))[..., None]
    return np.asarray(_BRIGHTNESS * colour, np.float32)


def _with_far_trees(
    sky: Float32[Array, "h w 3"], slope: Float[Array, " h"], rng: np.random.Generator
) -> Float32[Array, "h w 3"]:
    """Woods along the horizon, paler towards their foot, where more air lies before them."""
    angle = np.arange(_COLUMNS) * (2 * np.pi / _COLUMNS)
    hills = sum(rng.uniform(0.3, 1.0) / k * np.sin(k * angle + rng.uniform(0, 6.3)) for k in (1, 2, 3, 5, 9))
    crowns = np.abs(cv2.resize(rng.standard_normal((1, 360)), (_COLUMNS, 1))[0])
    twigs = rng.normal(0.0, 0.0025, _COLUMNS)
    height = np.clip(0.05 + 0.02 * np.asarray(hills) + 0.016 * crowns + twigs, 0.012, None)
    texture = cv2.resize(rng.random((_ROWS // 2, _COLUMNS // 2)), (_COLUMNS, _ROWS)).astype(np.float32)
    share = np.clip(slope[:, None] / height[None, :], 0, 1).astype(np.float32)
    woods = (0.5 + texture)[..., None] * _FAR_TREES + ((0.5 - 0.25 * share) * _BRIGHTNESS)[..., None] * _HORIZON
    return np.where((slope[:, None] < height[None, :])[..., None], woods, sky)


def sky_light(
    normal_up: Float32[Array, " n"], open_share: Float32[Array, " n"], *, indoors: bool
) -> Float32[Array, " n"]:
    """How much of an even sky's light falls on surfaces, relative to open level ground; the ground sends some back.

    Args:
        normal_up: Vertical component of the normals.
        open_share: Share of their own half space that is open to the sky.
        indoors: Whether walls and floor send back far more of the light, which comes from lamps.
    """
    bounce = np.float32(0.6 if indoors else 0.15)
    above = np.float32(0.5) * (1 + normal_up)
    return np.asarray(open_share * (above + bounce * (1 - above)))
