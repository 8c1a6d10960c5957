"""A LiDAR cloud cut to the fixed number of points that the network reads."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int64, UInt64

from navtool.pipeline.arrays import Array

_MM_PER_M = 1000.0
_SALTS = (0x9E3779B97F4A7C15, 0xD1B54A32D192ED03)

MAX_RANGE_M = 1000.0
"""Coordinates beyond this are no LiDAR returns and are dropped."""


class FixedSizeCloud(NamedTuple):
    """A cloud of fixed size."""

    points: Float32[Array, "size 3"]
    """[x, y, z] in metres, rounded to 1 mm; the rows from `kept` on repeat those before, from the first one on.

    A reader that ignores `kept` then sees the same surfaces, only denser, and never points at the robot's own place.
    An empty cloud is zero.
    """
    kept: int
    """Number of rows that are points."""


def valid_returns(xyz: Float[Array, "n 3"]) -> Bool[Array, " n"]:
    """The mask of real returns: finite and not at the sensor's origin, where drivers put beams without a return.

    Take it in the sensor's frame: after a transform, the origin lies elsewhere.
    """
    x, y, z = xyz.T
    mask: Array = np.isfinite(x) & np.isfinite(y) & np.isfinite(z) & ((x != 0) | (y != 0) | (z != 0))
    return mask


def fixed_size_cloud(
    xyz: Float[Array, "n 3"], size: int = 10_000, seed: int = 0, voxel_m: float = 0.05
) -> FixedSizeCloud:
    """The front half of a cloud, thinned to one point a voxel and then to at most `size` points.

    Points behind the robot (x < 0), beyond `MAX_RANGE_M`, not finite or exactly zero are dropped. Each voxel keeps one
    of its points, rounded to 1 mm, never a mean: points stay on measured surfaces. Of more than `size` voxels a random
    choice stays. Rows come ordered by place, which stores well.

    Guarantees: the result depends on the set of points, the size, the seed and the voxel alone, never on the order of
    the points or the machine; another seed makes another choice.

    Args:
        xyz: Points in the base frame (x forward) in metres. Take beams without a return out before the transform into
            that frame (`valid_returns`): they are zero in the sensor's frame only.
        size: Number of rows, at least 1. Reference: GrASPE, Table V: N_p = 10000.
        seed: Chooses the points that stay, 0 or more.
        voxel_m: Edge of a voxel in metres, in whole millimetres from 0.001 (points equal to 1 mm become one) to 10.

    Raises:
        ValueError: `size`, `seed` or `voxel_m` is out of range.

    Reference: GrASPE, IV-B.2: the cloud is restricted to [-pi/2, pi/2] about the robot's heading.
    """
    voxel_mm = round(voxel_m * _MM_PER_M)
    if size < 1 or seed < 0:
        raise ValueError(f"size is {size} and seed {seed}; set a size of at least 1 and a seed of at least 0")
    if not 1 <= voxel_mm <= 10_000 or abs(voxel_mm - voxel_m * _MM_PER_M) > 1e-6:
        raise ValueError(f"voxel_m is {voxel_m} m; set whole millimetres between 0.001 and 10")
    grid = _VoxelGrid(voxel_mm, seed)
    keys = grid.one_a_voxel(_front_mm(xyz))
    if len(keys) > size:
        # Distinct voxels have distinct ranks, so exactly `size` of them are below the next one.
        ranks = grid.ranks(keys)
        keys = keys[ranks < np.partition(ranks, size)[size]]
    points = (grid.points_mm(keys).T / _MM_PER_M).astype(np.float32)
    return FixedSizeCloud(np.resize(points, (size, 3)), len(keys))


def _front_mm(xyz: Float[Array, "n 3"]) -> Int64[Array, "3 m"]:
    """The real returns in front of the robot in whole millimetres."""
    columns = np.ascontiguousarray(xyz.T)
    x, y, z = columns
    # A comparison with NaN is false; so is that of infinity with the range.
    kept = (x >= 0) & (x <= MAX_RANGE_M) & (np.abs(y) <= MAX_RANGE_M) & (np.abs(z) <= MAX_RANGE_M)
    kept &= (x != 0) | (y != 0) | (z != 0)
    # float64: float32 would move points beyond 16 m by parts of a millimetre.
    front = columns.take(np.flatnonzero(kept), axis=1).astype(np.float64)
    front *= _MM_PER_M
    return np.rint(front, out=front).astype(np.int64)


class _VoxelGrid:
    """Points and voxels as whole numbers: key = voxel * (places in a voxel) + place, one key a cubic millimetre.

    Within `MAX_RANGE_M` and with voxels up to 10 m every key is below 2**63.

    The places of a voxel are numbered from a start that differs from voxel to voxel, so that the smallest key of a
    voxel is no particular corner of it.
    """

    def __init__(self, voxel_mm: int, seed: int) -> None:
        self._voxel = voxel_mm
        self._below = -(-int(MAX_RANGE_M * _MM_PER_M) // voxel_mm)
        self._across = 2 * self._below + 1
        self._places = voxel_mm**3
        self._rank_salt, self._start_salt = (_mix(np.uint64((seed + salt) % (1 << 64))) for salt in _SALTS)

    def one_a_voxel(self, points_mm: Int64[Array, "3 n"]) -> Int64[Array, " m"]:
        """The smallest key of each voxel with a point, in ascending order."""
        cell = points_mm // self._voxel
        place = points_mm - cell * self._voxel
        cell += self._below
        voxel = (cell[0] * self._across + cell[1]) * self._across + cell[2]
        numbered = (place[0] * self._voxel + place[1]) * self._voxel + place[2] - self._start(voxel)
        numbered += self._places * (numbered < 0)
        keys = np.sort(voxel * self._places + numbered)
        voxel = keys // self._places
        return np.asarray(keys[np.flatnonzero(np.diff(voxel, prepend=-1))])

    def ranks(self, keys: Int64[Array, " n"]) -> UInt64[Array, " n"]:
        """A seeded random order of the keys' voxels."""
        return _mix((keys // self._places).astype(np.uint64) + self._rank_salt)

    def points_mm(self, keys: Int64[Array, " n"]) -> Int64[Array, "3 n"]:
        """The points that the keys stand for."""
        voxel = keys // self._places
        place = keys - voxel * self._places + self._start(voxel)
        place -= self._places * (place >= self._places)
        cells = np.stack(_digits(voxel, self._across)) - self._below
        return np.asarray(cells * self._voxel + np.stack(_digits(place, self._voxel)))

    def _start(self, voxel: Int64[Array, " n"]) -> Int64[Array, " n"]:
        """Where the numbering of the voxel's places begins."""
        mixed = _mix(voxel.astype(np.uint64) + self._start_salt) >> np.uint64(1)
        # NumPy divides several numbers at a time, but takes remainders one by one.
        start: Array = (mixed - mixed // np.uint64(self._places) * np.uint64(self._places)).astype(np.int64)
        return start


def _digits(number: Int64[Array, " n"], base: int) -> list[Int64[Array, " n"]]:
    """The three digits of numbers below base cubed, the highest first."""
    rest = number // base
    high = rest // base
    return [high, rest - high * base, number - rest * base]


def _mix(values: UInt64[Array, "*n"] | np.uint64) -> UInt64[Array, "*n"]:
    """A one to one scrambling of 64 bits: SplitMix64's finaliser (Steele, Lea and Flood 2014)."""
    mixed = np.atleast_1d(np.asarray(values, np.uint64))
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(mixed ^ (mixed >> np.uint64(31)))
