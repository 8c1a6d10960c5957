"""Clouds of a spinning LiDAR in a world."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float32, Int, UInt8, UInt16

from navtool.pipeline.arrays import Array
from navtool.sim.sensors.echoes import Echoes, beam_share, find_echoes
from navtool.sim.sensors.lidar_config import LidarConfig, Returns
from navtool.sim.sensors.lidar_rays import MIXED_M, BeamRays, RayCaster, beam_directions
from navtool.sim.sensors.rain_and_dust import extinction_per_m, scattered_back
from navtool.sim.world.ray_scene import RayScene
from navtool.sim.world.scenario import WeatherConfig

AIR = 255
"""Number of what floats in the air, where a point's surface is asked for."""


class Cloud(NamedTuple):
    """The points of one turn in the order of firing, each in the sensor's frame at the time of its own firing."""

    xyz: Float32[Array, "n 3"]
    intensity: Float32[Array, " n"]
    """Whole numbers 1-255."""
    ring: UInt16[Array, " n"]
    """0 is the lowest laser."""
    time_s: Float32[Array, " n"]
    """Relative to the last firing of the turn, which stamps the cloud: at most 0."""
    surface: UInt8[Array, " n"]
    """Truth: number of the surface that most of the echo comes from; ``AIR`` for rain and dust."""


class Lidar:
    """A LiDAR: what does not change from turn to turn is computed once.

    A beam is five rays: on its axis, half a column to both sides, and on the axes of its neighbours, weighted by how
    much of its footprint at the range of each lies there.
    """

    def __init__(self, config: LidarConfig | None = None, weather: WeatherConfig | None = None) -> None:
        self.config = config if config is not None else LidarConfig()
        self.weather = weather if weather is not None else WeatherConfig()
        self._columns = self.config.columns
        self._caster = RayCaster(self.config)
        self._axes = beam_directions(np.array(self.config.elevation_rad)[:, None], self.config.azimuth_rad())
        self._offset_rad = (np.arange(-2, 3) * (self.config.column_rad / 2)).astype(np.float32)
        self._time_s = self.config.column_time_s()[:, None] + self.config.laser_time_s()[None, :]

    def measure(self, scene: RayScene, world_lidar: Float[Array, "columns 4 4"], rng: np.random.Generator) -> Cloud:
        """The cloud of one turn.

        Guarantee: equal arguments give equal clouds.

        Args:
            scene: What the beams meet.
            world_lidar: Pose of the sensor in the world at each of the ``config.columns`` firings, at the times
                ``config.column_time_s()``: a moving robot distorts its cloud.
            rng: Source of range noise, and of rain and dust.
        """
        rays = self._caster.cast(scene, world_lidar)
        strongest, other = self._echoes(rays, rng)
        return self._points(strongest, other, rng)

    def _echoes(self, rays: BeamRays, rng: np.random.Generator) -> tuple["_Found", "_Found"]:
        """The echoes of all beams, ring by ring: the one that single-return modes report, and dual mode's other."""
        reach, left, right = _three(rays.range_m)
        if self.weather.rain_mmph > 0 or self.weather.dust_per_m > 0:
            mixed = np.ones(reach.shape, bool)
        else:
            farthest = np.maximum(np.maximum(left, right), reach)
            mixed = farthest - np.minimum(np.minimum(left, right), reach) > np.float32(MIXED_M)
            if rays.glass.any():
                mixed |= self._window(rays.glass, np.arange(mixed.size)).any(axis=1).reshape(mixed.shape)
        axis, left, right = _three(rays.strength)
        strength = np.float32(0.25) * (left + right) + np.float32(0.5) * axis
        heard = (reach < self.config.max_range_m) & (strength >= self.config.faintest(reach))
        reach = np.where(heard, reach, np.float32(np.inf)).ravel()
        first = _Found(reach, strength.ravel(), rays.surface[:, ::2].ravel())
        other = _Found(np.full_like(reach, np.inf), np.zeros_like(reach), np.zeros(reach.size, np.uint8))
        index = np.flatnonzero(mixed)
        if index.size:
            self._resolve(rays, index, first, other, rng)
        return first, other

    def _resolve(
        self, rays: BeamRays, index: Int[Array, " m"], first: "_Found", other: "_Found", rng: np.random.Generator
    ) -> None:
        """Look at the pulses of beams whose parts lie apart, and enter their echoes."""
        reach, strength, surface = (self._window(part, index) for part in rays[:3])
        parts = [(reach, strength * self._share(reach), surface)]
        if rays.glass.any():
            reach, strength, surface = (self._window(part, index) for part in rays[3:6])
            parts.append((reach, strength * self._share(reach), surface))
        if self.weather.rain_mmph > 0 or self.weather.dust_per_m > 0:
            near, back = self._air(len(index), rng)
            parts.append((near, back, np.full(near.shape, AIR, np.uint8)))
        ranges, strengths, surfaces = (np.concatenate(columns, axis=1) for columns in zip(*parts, strict=True))
        loss = np.float32(-2 * extinction_per_m(self.weather))
        if loss:
            strengths *= np.exp(loss * np.minimum(ranges, np.float32(1e3)))
        ranges[ranges > self.config.max_range_m] = np.inf
        strongest, last, second = find_echoes(
            ranges, strengths, self.config.faintest(ranges), self.config.pulse_m, self.config.echo_gap_m
        )
        first.enter(index, last if self.config.returns is Returns.last else strongest, surfaces)
        if self.config.returns is Returns.dual:
            apart = last.range_m > strongest.range_m + np.float32(self.config.echo_gap_m)
            apart &= np.isfinite(last.range_m)
            other.enter(index, Echoes(*(np.where(apart, a, b) for a, b in zip(last, second, strict=True))), surfaces)

    def _window(self, values: Array, index: Int[Array, " m"]) -> Array:
        """The five rays of some beams: [m, 5]; beyond the first and the last ray of a ring, those."""
        ring, column = np.divmod(index.astype(np.int32), np.int32(self._columns))
        last = np.int32(2 * self._columns - 1)
        ray = np.clip(2 * column[:, None] + np.arange(-2, 3, dtype=np.int32), 0, last)
        return np.take(values, ray + ring[:, None] * (last + 1))

    def _share(self, range_m: Float32[Array, "m k"]) -> Float32[Array, "m k"]:
        """The share of its light that each beam sends along each of its rays."""
        width, aperture = self.config.divergence_rad[0], self.config.aperture_m[0]
        return beam_share(self._offset_rad, self.config.column_rad / 2, range_m, width, aperture)

    def _air(self, count: int, rng: np.random.Generator) -> tuple[Float32[Array, "m 2"], Float32[Array, "m 2"]]:
        across, up = self.config.aperture_m
        growth = float(np.sqrt(self.config.divergence_rad[0] * self.config.divergence_rad[1]))
        return scattered_back(
            self.weather, count, self.config.min_range_m, (across * up, growth), self.config.pulse_m, rng
        )

    def _points(self, first: "_Found", other: "_Found", rng: np.random.Generator) -> Cloud:
        """Add noise, leave out what is too near, and put the points in the order of firing."""
        rings, columns = self.config.rings, self._columns
        order = np.array(self.config.firing_order)
        parts = [first, other] if self.config.returns is Returns.dual else [first]
        beam = np.arange(rings * columns).reshape(rings, columns)[order].T.ravel()
        reach, strength, surface = (
            np.stack([values[beam] for values in column], axis=1).ravel() for column in zip(*parts, strict=True)
        )
        beam = np.repeat(beam, len(parts))
        limit = self.config.faintest(reach)
        with np.errstate(invalid="ignore", divide="ignore"):
            spread = np.float32(self.config.range_noise_m) * (1 + np.minimum(limit / strength, np.float32(1)))
        there = np.isfinite(reach)
        noise = rng.standard_normal(reach.shape, dtype=np.float32)
        step = np.float32(self.config.range_step_m)
        measured = np.round((np.where(there, reach + noise * spread, 0)) / step) * step
        there &= (measured >= self.config.min_range_m) & (reach >= self.config.min_range_m)
        beam, measured = beam[there], measured[there]
        ring, column = np.divmod(beam, columns)
        scale = np.float32(255 / self.config.full_scale)
        return Cloud(
            xyz=np.stack([axis.ravel()[beam] * measured for axis in self._axes], axis=-1),
            intensity=np.round(np.clip(strength[there] * scale, 1, 255)),
            ring=ring.astype(np.uint16),
            time_s=self._time_s[column, ring].astype(np.float32),
            surface=surface[there],
        )


def _three(values: Float32[Array, "rings rays"]) -> tuple[Array, Array, Array]:
    """What the ray on each beam's axis has, and those half a column beside it: [rings, columns] each."""
    axis, right = values[:, ::2], values[:, 1::2]
    left = np.empty(right.shape, values.dtype)
    left[:, 1:], left[:, 0] = right[:, :-1], axis[:, 0]
    return axis, left, right


class _Found(NamedTuple):
    """An echo of each beam of a turn, ring by ring; the arrays are filled in place."""

    range_m: Float32[Array, " n"]
    strength: Float32[Array, " n"]
    surface: UInt8[Array, " n"]

    def enter(self, index: Int[Array, " m"], echoes: Echoes, surface: UInt8[Array, "m k"]) -> None:
        self.range_m[index] = echoes.range_m
        self.strength[index] = echoes.strength
        self.surface[index] = surface[np.arange(len(index)), echoes.source]
