"""How far a LiDAR cloud can be trusted: the share of its points on edges and planes (GrASPE, eq. 3-5)."""

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float, Float32, Float64, Int64, Integer

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array
from navtool.pipeline.cloud_neighbourhoods import (
    Neighbourhoods,
    nearest_neighbourhoods,
    ring_neighbourhoods,
    rings_are_level,
)
from navtool.pipeline.eigenvalues import symmetric_eigenvalues

_FEWEST_POINTS = 10
_NO_RETURN_M = 1e6


class CloudFeatureMethod(StrEnum):
    """How it is decided whether a point lies on an edge, on a plane or in scatter."""

    loam = "loam"
    """Eq. 3 as printed: the neighbours' mean offset as a share of the point's distance from the sensor."""
    loam_spread = "loam_spread"
    """The neighbours' mean offset as a share of their mean distance from the point."""
    dimensionality = "dimensionality"
    """Which of line, plane and ball the neighbourhood resembles most, by the eigenvalues of its covariance."""


@dataclass(kw_only=True, slots=True)
class CloudReliabilityConfig:
    """Thresholds and weights of the cloud reliability."""

    method: CloudFeatureMethod = CloudFeatureMethod.dimensionality
    """loam, loam_spread or dimensionality."""
    c_max: float = 0.65
    """Smoothness from which on a point is an edge, in [0, 1]; for loam and loam_spread; the paper's Table V."""
    c_min: float = 0.35
    """Smoothness up to which a point is planar, in [0, c_max]; for loam and loam_spread; the paper's Table V."""
    edge_weight: float = 0.55
    """beta_e, the weight of the share of edges, in [0, 1]; the paper's Table V."""
    planar_weight: float = 0.45
    """beta_p, the weight of the share of planes, in [0, 1]; the paper's Table V."""
    reach: float = 0.07
    """Radius of a neighbourhood as a share of the point's distance from the sensor, above 0; for clouds with rings."""
    neighbours: int = 30
    """Number of nearest neighbours, at least 3; for clouds without rings."""
    min_neighbours: int = 6
    """A point with fewer neighbours is on no feature, at least 2."""
    max_points: int = 800
    """Number of points to look at, evenly spread over the cloud, at least 1."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 1, "edge_weight", "planar_weight", "c_max", "c_min"),
            fault(
                "c_min",
                f"{self.c_min} is above c_max = {self.c_max}: a point would be an edge and planar",
                when=self.c_min > self.c_max,
            ),
            outside(self, 0, np.inf, "reach", above=True, below=True, cure="give a share of a point's distance"),
            outside(self, 3, np.inf, "neighbours"),
            outside(self, 2, np.inf, "min_neighbours"),
            outside(self, 1, np.inf, "max_points"),
        )


class CloudReliability(NamedTuple):
    """The reliability of a cloud and what it is made of, each in [0, 1]."""

    cloud: float
    """r_point, the weighted sum; at most the larger of the two weights."""
    edge: float
    """r_edge, the share of points on edges."""
    planar: float
    """r_planar, the share of points on planes."""


class CloudFeatures(NamedTuple):
    """What the looked-at points of a cloud lie on."""

    at: Int64[Array, " m"]
    """The points' indices in the cloud."""
    edge: Bool[Array, " m"]
    """The point lies on an edge."""
    planar: Bool[Array, " m"]
    """The point lies on a plane, and not on an edge."""


def cloud_reliability(
    xyz: Float[Array, "n 3"], ring: Integer[Array, " n"] | None, config: CloudReliabilityConfig
) -> CloudReliability:
    r"""The reliability of a cloud.

    .. math::
        r_{edge} = |S_{edge}| / |P|, \quad r_{planar} = |S_{planar}| / |P|, \quad
        r_{point} = \beta_e r_{edge} + \beta_p r_{planar}

    over the points that `cloud_features` looks at. The result is deterministic, and 0 for a cloud of fewer than 10 real
    returns. Arithmetic is float32 for the points and float64 for the features.

    Args:
        xyz: Points in the sensor's frame in metres; those nearer than 1e-19 m, not finite or beyond 1000 km are no
            returns.
        ring: Ring (laser) of each point in any numbering, None where the cloud has none.
        config: Thresholds and weights.

    Reference: GrASPE, eq. (4) and (5).
    """
    features = cloud_features(xyz, ring, config)
    if not len(features.at):
        return CloudReliability(0.0, 0.0, 0.0)
    edge, planar = float(features.edge.mean()), float(features.planar.mean())  # eq. (4)
    weighted = config.edge_weight * edge + config.planar_weight * planar  # eq. (5)
    return CloudReliability(min(weighted, 1.0), edge, planar)


def cloud_features(
    xyz: Float[Array, "n 3"], ring: Integer[Array, " n"] | None, config: CloudReliabilityConfig
) -> CloudFeatures:
    """What up to `max_points` points of a cloud lie on; none of them where it has fewer than 10 real returns.

    A cloud with level rings is looked at in windows along ring and azimuth, another one by its points' nearest
    neighbours; see `rings_are_level`, `ring_neighbourhoods` and `nearest_neighbourhoods`. A point with too few
    neighbours lies on nothing.

    Note:
        Every method has the same neighbourhoods, so they differ in the feature alone. A single ring, as planar scanners
        have, meets every surface in a line: by dimensionality its edges are structure, and an area is scatter.
    """
    with np.errstate(over="ignore"):  # float64 beyond float32 becomes infinite: no return
        columns = np.ascontiguousarray(xyz.T, np.float32)
        squared = np.einsum("in,in->n", columns, columns)
    real = (squared > 0) & (squared < _NO_RETURN_M**2)  # comparisons with NaN are false
    if np.count_nonzero(real) < _FEWEST_POINTS:
        return CloudFeatures(np.zeros(0, np.int64), np.zeros(0, np.bool_), np.zeros(0, np.bool_))
    rings, returned = ring, None
    if not real.all():
        returned = np.flatnonzero(real)
        columns = columns.take(returned, axis=1)
        rings = None if ring is None else ring[returned]
    if rings is None or not rings_are_level(columns, rings):
        neighbours = min(config.neighbours, columns.shape[1] - 1)
        around = nearest_neighbourhoods(columns, neighbours, config.max_points)
    else:
        around = ring_neighbourhoods(columns, rings, config.reach, config.max_points)
    if config.method is CloudFeatureMethod.dimensionality:
        edge, planar = _by_dimensionality(around)
        planar &= rings is None or bool((rings != rings[0]).any())
    else:
        smoothness = _smoothness(around, columns, config.method)
        # Points that all lie on one place have no surface.
        spread = around.difference.any(axis=(0, 2))
        edge, planar = spread & (smoothness >= config.c_max), spread & (smoothness <= config.c_min)
    enough = around.size >= config.min_neighbours
    at = around.centre if returned is None else returned[around.centre]
    return CloudFeatures(at, edge & enough, planar & ~edge & enough)


def _smoothness(
    around: Neighbourhoods, columns: Float32[Array, "3 n"], method: CloudFeatureMethod
) -> Float64[Array, " m"]:
    r"""The surface smoothness of each centre.

    .. math::
        c_l = \frac{1}{\|X_l\| \cdot |M|} \left\| \sum_{k \in M, k \ne l} (X_l - X_k) \right\|

    Reference: GrASPE, eq. (3), after Zhang and Singh, "LOAM", 2014.

    Note:
        loam_spread divides by the neighbours' summed distance instead of by the range, which puts c into [0, 1].
    """
    offset = np.linalg.norm(around.difference.sum(axis=2, dtype=np.float64), axis=0)
    if method is CloudFeatureMethod.loam:
        scale = np.linalg.norm(columns[:, around.centre], axis=0) * around.size
    else:
        scale = np.linalg.norm(around.difference, axis=0).sum(axis=1, dtype=np.float64)
    return np.asarray(offset / np.where(scale > 0, scale, 1.0))  # eq. (3)


def _by_dimensionality(around: Neighbourhoods) -> tuple[Bool[Array, " m"], Bool[Array, " m"]]:
    r"""Which centres have a linear and which a planar neighbourhood.

    .. math::
        a_{1D} = (\sigma_1 - \sigma_2) / \sigma_1, \quad a_{2D} = (\sigma_2 - \sigma_3) / \sigma_1, \quad
        a_{3D} = \sigma_3 / \sigma_1

    with the standard deviations along the neighbourhood's principal axes; the largest of the three decides, and a
    neighbourhood without extent is a ball. Reference: Demantke et al., "Dimensionality based scale selection in 3D
    LiDAR point clouds", 2011.
    """
    x, y, z = around.difference
    size = around.size + 1.0  # the centre belongs to its neighbourhood
    pairs = ((x, x), (x, y), (x, z), (y, y), (y, z), (z, z))
    second = np.stack([np.einsum("mk,mk->m", a, b) for a, b in pairs]) / size
    mx, my, mz = np.einsum("imk->im", around.difference) / size
    means = np.stack([mx * mx, mx * my, mx * mz, my * my, my * mz, mz * mz])
    sigma = np.sqrt(np.maximum(symmetric_eigenvalues(second - means), 0.0))
    line, plane, ball = sigma[0] - sigma[1], sigma[1] - sigma[2], sigma[2]
    edge = (line > plane) & (line > ball)
    return edge, (plane >= line) & (plane > ball)
