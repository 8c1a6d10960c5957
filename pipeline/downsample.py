"""A LiDAR cloud cut to the fixed number of points that the network reads."""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Int32, Int64, UInt64

from navtool.pipeline.arrays import Array

_MM_PER_M = 1000.0
_SALT = 0xD1B54A32D192ED03
_ODD = 0x1E3779B97F4A7C15
_ODD_INVERSE = pow(_ODD, -1, 1 << 63)
"""Inverse of the odd number, for every number of low bits up to 63."""

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
    ranks = grid.ranks(keys)
    if len(keys) > size:
        # Distinct voxels have distinct ranks, so exactly `size` of them are below the next one.
        chosen = np.flatnonzero(ranks < np.partition(ranks, size)[size])
        keys, ranks = keys.take(chosen), ranks.take(chosen)
    # Whole millimetres are exact in float32, and so is the quotient but for one rounding.
    points = np.ascontiguousarray(grid.points_mm(keys, ranks).T, np.float32)
    points /= np.float32(_MM_PER_M)
    return FixedSizeCloud(points if len(keys) == size else np.resize(points, (size, 3)), len(keys))


def _front_mm(xyz: Float[Array, "n 3"]) -> Int32[Array, "3 m"]:
    """The real returns in front of the robot in whole millimetres."""
    columns = np.ascontiguousarray(xyz.T)
    # A comparison with NaN is false; so is that of infinity with the range.
    front = columns.take(np.flatnonzero(columns[0] >= 0), axis=1)
    kept = (np.abs(front) <= MAX_RANGE_M).all(axis=0) & (front != 0).any(axis=0)
    if not kept.all():
        front = front.compress(kept, axis=1)
    # float64: float32 would move points beyond 16 m by parts of a millimetre.
    front_mm = np.multiply(front, _MM_PER_M, dtype=np.float64)
    return np.asarray(np.rint(front_mm, out=front_mm).astype(np.int32))


class _VoxelGrid:
    """Points and voxels as whole numbers: a key is the voxel's number and, in its low bits, the place within.

    Within `MAX_RANGE_M` in front and with voxels up to 10 m every key is below 2**63.

    A seeded hash of the voxel is its rank among the others, and scrambles the places within: the smallest key of a
    voxel is then no particular corner of it.
    """

    def __init__(self, voxel_mm: int, seed: int) -> None:
        self._voxel = voxel_mm
        self._below = -(-int(MAX_RANGE_M * _MM_PER_M) // voxel_mm)
        self._across = 2 * self._below + 1
        self._place_bits = (voxel_mm**3 - 1).bit_length()
        self._place_mask = (1 << self._place_bits) - 1
        self._salt = np.uint64((seed * _ODD + _SALT) % (1 << 64))

    def one_a_voxel(self, points_mm: Int32[Array, "3 n"]) -> Int64[Array, " m"]:
        """The smallest key of each voxel with a point, in ascending order."""
        cell = points_mm // self._voxel
        place = (points_mm - cell * self._voxel).astype(np.int64)
        cell[1:] += self._below
        voxel = _joined(cell.astype(np.int64), self._across)
        # Times an odd number, and moved by one of the voxel's own: one to one within the low bits.
        scrambled = _joined(place, self._voxel) * _ODD + self._hash(voxel).view(np.int64)
        keys = np.sort((voxel << self._place_bits) | (scrambled & self._place_mask))
        voxel = keys >> self._place_bits
        first: Array = np.ones(len(keys), np.bool_)
        np.not_equal(voxel[1:], voxel[:-1], out=first[1:])
        return keys.compress(first)

    def ranks(self, keys: Int64[Array, " n"]) -> UInt64[Array, " n"]:
        """A seeded random order of the keys' voxels."""
        return self._hash(keys >> self._place_bits)

    def points_mm(self, keys: Int64[Array, " n"], ranks: UInt64[Array, " n"]) -> Int64[Array, "3 n"]:
        """The points that the keys stand for."""
        place = ((keys - ranks.view(np.int64)) * _ODD_INVERSE) & self._place_mask
        points = _digits(keys >> self._place_bits, self._across)
        points[1:] -= self._below
        points *= self._voxel
        points += _digits(place, self._voxel)
        return points

    def _hash(self, voxel: Int64[Array, " n"]) -> UInt64[Array, " n"]:
        """A one to one scrambling of 64 bits: SplitMix64's finaliser (Steele, Lea and Flood 2014)."""
        mixed = voxel.view(np.uint64) + self._salt
        mixed ^= mixed >> np.uint64(30)
        mixed *= np.uint64(0xBF58476D1CE4E5B9)
        mixed ^= mixed >> np.uint64(27)
        mixed *= np.uint64(0x94D049BB133111EB)
        mixed ^= mixed >> np.uint64(31)
        return mixed


def _joined(digits: Int64[Array, "3 n"], base: int) -> Int64[Array, " n"]:
    """Numbers of three digits, the highest first."""
    return np.asarray((digits[0] * base + digits[1]) * base + digits[2])


def _digits(number: Int64[Array, " n"], base: int) -> Int64[Array, "3 n"]:
    """The three digits of numbers below base cubed, the highest first."""
    # NumPy divides several numbers at a time, but takes remainders one by one.
    digits: Int64[Array, "3 n"] = np.empty((3, len(number)), np.int64)
    high, middle, low = digits
    np.floor_divide(number, base, out=middle)
    np.subtract(number, middle * base, out=low)
    np.floor_divide(middle, base, out=high)
    middle -= high * base
    return digits
