"""Simple grounds of one kind each: what tests, benchmarks and the documented figures walk on."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from scipy.ndimage import gaussian_filter

from navtool.pipeline.arrays import Array
from navtool.sim.errors import SimError
from navtool.sim.legged.footing import Grip


@dataclass(frozen=True, kw_only=True, slots=True)
class Patch:
    """A ground of one kind all over."""

    origin_m: tuple[float, float]
    cell_m: float
    heights_m: Float64[Array, "rows columns"]
    friction: float
    stiffness_npm: float
    damping_nspm: float
    drag_nspm2: float = 0.0
    cover_m: float = 0.0
    stems_n: float = 0.0

    def grip_at(self, x_m: Float64[Array, " n"], y_m: Float64[Array, " n"]) -> Grip:  # noqa: ARG002 the same everywhere
        """Return how the ground holds: the same everywhere."""
        values = (self.friction, self.stiffness_npm, self.damping_nspm, self.drag_nspm2, self.cover_m, self.stems_n)
        return Grip(*(np.full(x_m.shape, value) for value in values))


_CELL_M = 0.04
_LONG_M, _WIDE_M = 28.0, 8.0
_ORIGIN_M = (-3.0, -4.0)


def concrete() -> Patch:
    """Level, hard and rough to the sole."""
    return _patch(np.zeros(_shape()), friction=0.9, stiffness_npm=1e6, damping_nspm=500.0)


def granular(seed: int) -> Patch:
    """Loose gravel on sand: small bumps of 1 cm, feet sink in by a centimetre and slip sooner."""
    bumps = 0.010 * _noise(seed, 0.06) + 0.02 * _noise(seed + 1, 0.6)
    return _patch(bumps, friction=0.55, stiffness_npm=14_000.0, damping_nspm=700.0)


def mud() -> Patch:
    """Level and soft: feet sink in by 4 cm, come out without being pushed back, and slip."""
    drag = {"drag_nspm2": 60.0, "cover_m": 0.05}
    return _patch(np.zeros(_shape()), friction=0.4, stiffness_npm=4_000.0, damping_nspm=600.0, **drag)


def grass(seed: int, drag_nspm2: float = 60.0) -> Patch:
    """Tall grass of 40 cm on uneven soil."""
    bumps = 0.02 * _noise(seed, 0.5)
    return _patch(bumps, friction=0.6, stiffness_npm=30_000.0, damping_nspm=500.0, drag_nspm2=drag_nspm2, cover_m=0.4)


def rocks(seed: int, low_m: float = 0.05, high_m: float = 0.12) -> Patch:
    """A bed of stones 20 to 50 cm across that stand out by `low_m` to `high_m`.

    Raises:
        SimError: The heights are negative or the wrong way round.
    """
    if not 0 <= low_m <= high_m:
        raise SimError(f"stones of {low_m} to {high_m} m", cure="0 <= low_m <= high_m")
    rng = np.random.default_rng([seed, 3])
    rows, columns = _shape()
    heights = np.zeros((rows, columns))
    stones = round(_LONG_M * _WIDE_M / 0.16)
    for x, y, radius, height in zip(
        rng.uniform(0, columns, stones),
        rng.uniform(0, rows, stones),
        rng.uniform(0.10, 0.25, stones) / _CELL_M,
        rng.uniform(low_m, high_m, stones),
        strict=True,
    ):
        near = slice(max(0, int(y - radius)), int(y + radius) + 2), slice(max(0, int(x - radius)), int(x + radius) + 2)
        across, along = np.meshgrid(np.arange(columns)[near[1]] - x, np.arange(rows)[near[0]] - y)
        inside = 1.0 - (across**2 + along**2) / radius**2
        heights[near] = np.maximum(heights[near], height * np.sqrt(np.maximum(inside, 0.0)))
    return _patch(heights + 0.004 * _noise(seed, 0.08), friction=0.7, stiffness_npm=4e5, damping_nspm=500.0)


def _patch(heights: Float64[Array, "rows columns"], **grip: float) -> Patch:
    return Patch(origin_m=_ORIGIN_M, cell_m=_CELL_M, heights_m=heights, **grip)


def _shape() -> tuple[int, int]:
    return round(_WIDE_M / _CELL_M) + 1, round(_LONG_M / _CELL_M) + 1


def _noise(seed: int, length_m: float) -> Float64[Array, "rows columns"]:
    """Return smooth noise of unit deviation with features of a length."""
    rough = np.random.default_rng([seed, 1]).standard_normal(_shape())
    smooth = gaussian_filter(rough, length_m / _CELL_M / 2, mode="reflect")
    return np.asarray(smooth / smooth.std())
