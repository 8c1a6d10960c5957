"""Ways by velocities against ways by poses, as complex numbers: forward and to the left."""

import numpy as np
from jaxtyping import Bool, Complex128, Float64

from navtool.base.note import Note
from navtool.pipeline.arrays import Array

TURNED = "odometry.twist-turned"
"""Code of the notes that say how speeds were turned."""

FIT = 0.7
"""Velocities fit where they give so many of the ways of the poses,"""
_CLOSE = 0.3
"""each but for such a share of it."""
STEADY = 0.15
"""A factor or a turn that is steady leaves a smaller middle share of the way."""
_CREEP = 0.02
"""A smaller share of the usual velocity is none."""
ONE_WAY = 0.3
"""Robots mostly drive forward: such a share of the way, less what goes backwards, says which way that is."""


def plane(travel: Float64[Array, "windows columns"]) -> Complex128[Array, " windows"]:
    """Travel forward and to the left, or along x and y, as complex numbers."""
    return np.asarray(travel[:, 0] + 1j * travel[:, 1])


def both_move(
    way: Complex128[Array, " w"], measured: Complex128[Array, " w"], least: Float64[Array, " w"]
) -> Bool[Array, " w"]:
    """Where poses and velocities both move, in whatever unit; where one of them stands is a matter of rows."""
    return np.asarray((np.abs(way) > 2 * least) & (np.abs(measured) > _CREEP * np.quantile(np.abs(measured), 0.95)))


def fitting(way: Complex128[Array, " w"], measured: Complex128[Array, " w"], least: Float64[Array, " w"]) -> float:
    """Share of the ways that the velocities give."""
    if not way.size:
        return 1.0
    longest = np.maximum(np.abs(way), np.abs(measured))
    return float((np.abs(way - measured) < _CLOSE * longest + least / 2).mean())


def misfit(way: Complex128[Array, " w"], measured: Complex128[Array, " w"]) -> float:
    """Middle share of the ways by which the velocities miss them."""
    return float(np.median(np.abs(way - measured) / np.maximum(np.abs(way), np.abs(measured))))


def middle(way: Complex128[Array, " w"], measured: Complex128[Array, " w"]) -> complex:
    """The number by which velocities are multiplied to give the ways: by those near the middle size and angle."""
    both = (np.abs(measured) > 1e-9) & (np.abs(way) > 1e-9)
    if not both.any():
        return 0j
    way, measured = way[both], measured[both]
    ratio = way / measured
    turn = np.sum(ratio / np.abs(ratio) * np.minimum(np.abs(way), np.abs(way).mean()))
    factor = complex(np.median(np.abs(ratio)) * (turn / abs(turn) if abs(turn) > 0 else 1.0))
    near = np.abs(ratio - factor) < _CLOSE * abs(factor)
    if not near.any():
        return factor
    return complex((way[near] * measured[near].conj()).sum() / (np.abs(measured[near]) ** 2).sum())


def unit_note(what: str, name: str, factor: float, wanted: str) -> Note:
    """A note that velocities were in another unit than wanted."""
    text = f"odometry: by its poses its {what} are in {name}, not in {wanted}; divided by {factor:.4g}"
    return Note("odometry.twist-unit", text)
