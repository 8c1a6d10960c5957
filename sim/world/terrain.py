"""The ground of a scenario: hills, regions of terrain, and the relief and stones of each."""

import cv2
import numpy as np
from jaxtyping import Float, UInt8

from navtool.pipeline.arrays import Array
from navtool.sim.world.height_field import HeightField
from navtool.sim.world.noise import smooth_noise
from navtool.sim.world.randomness import Purpose, generator
from navtool.sim.world.scenario import RegionConfig, RegionShape, ScenarioConfig
from navtool.sim.world.surfaces import surface_number, surface_values

_HILL_M = 15.0
_RELIEF_M = ((0.35, 0.6), (0.9, 0.8))
"""Wavelength in metres and share of the relief's deviation; the squares of the shares add up to 1."""
_STONES_PER_M2 = 2.5
_LEVEL_M = 3.0
_EDGE_M = 0.25
"""Over this distance the relief of one region passes into its neighbour's."""


def make_ground(config: ScenarioConfig, place: str, seed: int) -> HeightField:
    """The ground of one place; its drag is that of its surfaces alone.

    Guarantee: equal arguments give equal grids, bit by bit.
    """
    side = round(config.side_m / config.cell_m)
    surface = _surfaces(config, side, generator(place, seed, Purpose.REGIONS))
    rng = generator(place, seed, Purpose.RELIEF)
    if config.room is not None:
        heights: Array = np.zeros((side + 1, side + 1))
    else:
        heights = config.hills_m * smooth_noise(rng, side + 1, _HILL_M / config.cell_m).astype(np.float64)
        heights += _relief(config, surface, rng)
        _add_stones(heights, surface, config.cell_m, rng)
        heights *= _level_at_the_edge(side + 1, config.cell_m)
    drag = surface_values("drag_per_m")[surface]
    return HeightField(cell_m=config.cell_m, heights_m=heights, surface=surface, drag_per_m=drag)


def _level_at_the_edge(nodes: int, cell_m: float) -> Float[Array, "m m"]:
    """1 inside, falling smoothly to 0 over the outermost metres."""
    inward = np.minimum(np.arange(nodes), np.arange(nodes)[::-1]) * (cell_m / _LEVEL_M)
    share = np.clip(inward, 0, 1)
    smooth = share * share * (3 - 2 * share)
    return np.asarray(smooth[:, None] * smooth[None, :])


def _surfaces(config: ScenarioConfig, side: int, rng: np.random.Generator) -> UInt8[Array, "n n"]:
    surface = np.full((side, side), surface_number(config.ground), np.uint8)
    for region in config.regions:
        surface[_covered(region, config, side, rng)] = surface_number(region.surface)
    return surface


def _covered(region: RegionConfig, config: ScenarioConfig, side: int, rng: np.random.Generator) -> Array:
    """Which cells a region covers."""
    axis = (np.arange(side) + 0.5 - side / 2) * config.cell_m
    wavy = smooth_noise(rng, side, max(region.size_m, 1.0) / config.cell_m)
    match region.shape:
        case RegionShape.patches:
            return np.asarray(wavy > np.quantile(wavy, 1 - region.share))
        case RegionShape.path:
            bend = 2.0 * smooth_noise(rng, side, 14.0 / config.cell_m)[0] + rng.uniform(-2.0, 2.0)
            ragged = 0.06 * region.size_m * wavy
            return np.asarray(np.abs(axis[:, None] - bend[None, :]) < region.size_m / 2 + ragged)
        case RegionShape.band:
            along = axis[None, :] + 0.5 * wavy
            return np.asarray((along > region.from_m) & (along < region.to_m))


def _relief(config: ScenarioConfig, surface: UInt8[Array, "n n"], rng: np.random.Generator) -> Float[Array, "m m"]:
    """Height of the small unevenness at each node."""
    deviation = np.pad(surface_values("relief_m")[surface], ((0, 1), (0, 1)), mode="edge")
    deviation = cv2.GaussianBlur(deviation, (0, 0), _EDGE_M / config.cell_m)
    nodes = len(deviation)
    waves = sum(share * smooth_noise(rng, nodes, wave / config.cell_m / 2) for wave, share in _RELIEF_M)
    return np.asarray(deviation * waves, np.float64)


def _add_stones(
    heights: Float[Array, "m m"], surface: UInt8[Array, "n n"], cell_m: float, rng: np.random.Generator
) -> None:
    """Raise rounded stones out of the regions that have them; a stone is at least two cells wide."""
    largest = surface_values("stone_m")
    side = len(surface)
    count = round(_STONES_PER_M2 * (side * cell_m) ** 2)
    places, sizes = rng.uniform(0, side, (count, 2)), rng.uniform(0.35, 1.0, count)
    row, column = places.astype(np.int64).T
    tall = sizes * largest[surface[row, column]]
    for index in np.flatnonzero(tall > 0.02).tolist():
        height = float(tall[index])
        reach = max(1.3 * height / cell_m, 2.0)
        low = np.maximum(np.ceil(places[index] - reach).astype(int), 0)
        high = np.minimum(np.floor(places[index] + reach).astype(int) + 1, side + 1)
        rows, columns = np.mgrid[low[0] : high[0], low[1] : high[1]]
        near = 1 - ((rows - places[index, 0]) ** 2 + (columns - places[index, 1]) ** 2) / reach**2
        stone = height * np.sqrt(np.maximum(near, 0.0))
        heights[low[0] : high[0], low[1] : high[1]] += np.where(near > 0, stone, 0.0) * 0.8
