"""From what the parts of a beam meet to the echoes that a receiver detects."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float32, Int

from navtool.pipeline.arrays import Array


class Echoes(NamedTuple):
    """One echo a beam."""

    range_m: Float32[Array, " m"]
    """Infinite where there is none."""
    strength: Float32[Array, " m"]
    """Relative to a white Lambertian plate that faces the sensor and fills the beam."""
    source: Int[Array, " m"]
    """Which of the beam's contributions peaks there; 0 where there is none."""


def beam_share(
    offset_rad: Float32[Array, " k"],
    cell_rad: float,
    range_m: Float32[Array, "*m k"],
    divergence_rad: float,
    aperture_m: float,
) -> Float32[Array, "*m k"]:
    """The share of a beam's light that falls on the cells in which its rays lie, side by side.

    The beam is as wide as its aperture where it leaves the sensor and opens by its divergence. Each ray stands for a
    cell of azimuth; the shares of a beam that fills a whole row of cells add up to 1.

    Args:
        offset_rad: Azimuth of each ray's cell relative to the beam's axis, evenly spaced and symmetric.
        cell_rad: Width of a cell.
        range_m: Where each ray meets something.
        divergence_rad: Full angle by which the beam widens.
        aperture_m: Its width at the sensor.
    """
    reach = np.float32(offset_rad.max(initial=0.0) + cell_rad / 2)
    half = np.minimum(np.float32(0.5) * (divergence_rad + aperture_m / np.maximum(range_m, np.float32(0.05))), reach)
    half_cell = np.float32(cell_rad / 2)
    overlap = np.minimum(offset_rad + half_cell, half) - np.maximum(offset_rad - half_cell, -half)
    return np.asarray(np.clip(overlap, 0, None) / (2 * half), np.float32)


def find_echoes(
    range_m: Float32[Array, "m k"],
    strength: Float32[Array, "m k"],
    faintest: Float32[Array, "m k"],
    pulse_m: float,
    gap_m: float,
) -> tuple[Echoes, Echoes, Echoes]:
    """The strongest, the last and the second strongest echo of beams whose light returns from several ranges.

    What returns from ranges within the length of a pulse adds up, weighted by how much the pulses overlap; the range of
    an echo is the mean of what adds up to it.

    Args:
        range_m: Where the parts of each beam meet something; infinite for nothing.
        strength: What returns from there, its share of the beam included.
        faintest: Least strength that is detected at each of these ranges.
        pulse_m: Standard deviation of the pulse.
        gap_m: Least distance of a second echo from the strongest.
    """
    met = np.isfinite(range_m) & (strength > 0)
    near = np.where(met, range_m, np.float32(1e9))
    energy = np.where(met, strength, np.float32(0))
    apart = near[:, :, None] - near[:, None, :]
    overlap = np.exp(np.float32(-0.5 / pulse_m**2) * apart * apart)
    overlap *= energy[:, None, :]
    summed = overlap.sum(axis=2)
    centre = np.einsum("mjk,mk->mj", overlap, near) / np.maximum(summed, np.float32(1e-20))
    heard = met & (summed >= faintest)
    loud = np.where(heard, summed, np.float32(0))
    rows = np.arange(len(near))
    strongest = _pick(rows, loud.argmax(axis=1), heard, centre, summed)
    last = _pick(rows, np.where(heard, centre, np.float32(-1)).argmax(axis=1), heard, centre, summed)
    distinct = heard & (np.abs(centre - strongest.range_m[:, None]) >= np.float32(gap_m))
    second = _pick(rows, np.where(distinct, summed, np.float32(0)).argmax(axis=1), distinct, centre, summed)
    return strongest, last, second


def _pick(
    rows: Int[Array, " m"],
    column: Int[Array, " m"],
    allowed: Bool[Array, "m k"],
    centre: Float32[Array, "m k"],
    summed: Float32[Array, "m k"],
) -> Echoes:
    there = allowed[rows, column]
    return Echoes(
        np.where(there, centre[rows, column], np.float32(np.inf)),
        np.where(there, summed[rows, column], np.float32(0)),
        np.where(there, column, 0),
    )
