"""How far a LiDAR cloud can be trusted: the share of its points on edges and planes (GrASPE, eq. 3-5)."""

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Float64, UInt16
from scipy.spatial import cKDTree

from navtool.pipeline.arrays import Array


class CloudFeatureMethod(StrEnum):
    """How a point is told to lie on an edge, on a plane or in scatter."""

    loam = "loam"
    loam_spread = "loam_spread"
    dimensionality = "dimensionality"


@dataclass(kw_only=True, slots=True)
class CloudReliabilityConfig:
    """Thresholds and weights of the cloud reliability."""

    method: CloudFeatureMethod = CloudFeatureMethod.dimensionality
    """loam, loam_spread or dimensionality."""
    c_max: float = 0.65
    """Smoothness from which on a point is an edge, in [0, 1]; for loam and loam_spread."""
    c_min: float = 0.35
    """Smoothness up to which a point is planar, in [0, 1]; for loam and loam_spread."""
    edge_weight: float = 0.55
    """beta_e, the weight of the share of edges, in [0, 1]."""
    planar_weight: float = 0.45
    """beta_p, the weight of the share of planes, in [0, 1]."""
    neighbours: int = 20
    """Neighbours of a point where the cloud has no rings."""
    max_points: int = 2000
    """Points evaluated where the cloud has no rings."""


class CloudReliability(NamedTuple):
    """The reliability of a cloud and what it is made of, each in [0, 1]."""

    cloud: float
    edge: float
    planar: float


def cloud_reliability(
    xyz: Float[Array, "n 3"], ring: UInt16[Array, " n"] | None, config: CloudReliabilityConfig
) -> CloudReliability:
    """The reliability of a cloud in the sensor's frame."""
    del ring
    points = xyz[np.isfinite(xyz).all(axis=1) & (xyz != 0).any(axis=1)].astype(np.float64)
    if len(points) <= config.neighbours:
        return CloudReliability(0.0, 0.0, 0.0)
    queried = points[:: max(1, len(points) // config.max_points)]
    _, near = cKDTree(points).query(queried, k=config.neighbours + 1)
    difference = queried[:, None] - points[near]
    edge, planar = _shares(queried, difference, config)
    return CloudReliability(config.edge_weight * edge + config.planar_weight * planar, edge, planar)


def _shares(
    queried: Float64[Array, "m 3"], difference: Float64[Array, "m k 3"], config: CloudReliabilityConfig
) -> tuple[float, float]:
    if config.method is CloudFeatureMethod.dimensionality:
        centred = difference - difference.mean(axis=1, keepdims=True)
        values = np.linalg.eigvalsh(np.einsum("mki,mkj->mij", centred, centred))
        sigma = np.sqrt(np.maximum(values, 0.0))[:, ::-1]
        features = np.column_stack([sigma[:, 0] - sigma[:, 1], sigma[:, 1] - sigma[:, 2], sigma[:, 2]])
        kind = np.argmax(features, axis=1)
        return float(np.mean(kind == 0)), float(np.mean(kind == 1))
    if config.method is CloudFeatureMethod.loam:
        scale = np.linalg.norm(queried, axis=1) * config.neighbours
    else:
        scale = np.linalg.norm(difference, axis=2).sum(axis=1)
    smoothness = np.linalg.norm(difference.sum(axis=1), axis=1) / np.maximum(scale, 1e-12)
    return float(np.mean(smoothness >= config.c_max)), float(np.mean(smoothness <= config.c_min))
