"""How well each cloud feature method tells structure from vegetation: areas under the ROC curve.

Clouds: scenes ray-cast here for a 16-ring scanner (ground, boxes and poles; or ground under tall grass and bushes), and
one real labelled scan of RELLIS-3D (an Ouster OS1-64: as it is, thinned to 16 rings, and without rings) where its data
lie beside the repository or NAVTOOL_DATA names their folder. Only figures leave this script.

Levels: "points" ranks single points by their part in r_point; "patches" ranks sectors of 5 degrees and a few metres by
their r_point; "scenes" ranks whole clouds. Run: `python benchmarks/cloud_reliability_auc.py`.
"""

import os
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from _report import Row, median_seconds, write_report
from numpy.typing import NDArray
from scipy.stats import rankdata

from navtool.pipeline.cloud_reliability import (
    CloudFeatureMethod,
    CloudReliabilityConfig,
    cloud_features,
    cloud_reliability,
)

ROOT = Path(__file__).resolve().parents[1]
SCENES = 30
STRUCTURE, VEGETATION, NEITHER = 1, 0, -1
RELLIS_STRUCTURE = (3, 23, 31, 33)  # grass (mown ground), concrete, puddle, mud
RELLIS_VEGETATION = (4, 19)  # tree, bush
PATCH_RINGS_M = (2.0, 5.0, 8.0, 12.0, 18.0, 30.0)

type Floats = NDArray[np.float64]


class LabelledCloud(NamedTuple):
    """A scan whose points are known to be structure, vegetation or neither."""

    xyz: NDArray[np.float32]
    ring: NDArray[np.uint16] | None
    kind: NDArray[np.int64]


class Ranked(NamedTuple):
    """What a method gives to points, patches or scenes, and which of them are structure."""

    score: Floats
    kind: NDArray[np.int64]


class Measured(NamedTuple):
    """The areas under the ROC curve of all methods on the same clouds, and the means that they separate."""

    data: str
    level: str
    auc: dict[CloudFeatureMethod, float]
    structured: int
    vegetated: int
    mean_structured: dict[CloudFeatureMethod, float]
    """Mean r_point of what is structured."""
    mean_vegetated: dict[CloudFeatureMethod, float]


def main() -> None:
    figures = simulated_rows()
    scan = rellis_scan()
    if scan is None:
        print("RELLIS-3D's scan 000104 is missing: its rows are left out; set NAVTOOL_DATA to the recordings' folder")
    else:
        for name, cloud in real_variants(scan):
            figures += [point_row(name, [cloud]), patch_row(name, cloud)]
    write_report("cloud_reliability_auc", [*report_rows(figures), *time_rows()])


def simulated_rows() -> list[Measured]:
    """Thirty structured and thirty vegetated scenes: whole scenes and single points."""
    structured = [simulated_scan(seed, vegetated=False) for seed in range(SCENES)]
    vegetated = [simulated_scan(seed, vegetated=True) for seed in range(SCENES)]
    ranked = {}
    for method in CloudFeatureMethod:
        config = CloudReliabilityConfig(method=method)
        scores = [cloud_reliability(scan.xyz, scan.ring, config).cloud for scan in (*structured, *vegetated)]
        ranked[method] = Ranked(np.array(scores), np.repeat([STRUCTURE, VEGETATION], SCENES))
    name = "simulated, 16 rings"
    return [measured(name, "scenes", ranked), point_row(name, [*structured, *vegetated])]


def simulated_scan(seed: int, *, vegetated: bool) -> LabelledCloud:
    """A scan of 16 rings from 0.7 m above flat ground, with 1.5 cm range noise.

    In vegetation a ray ends after an exponentially distributed way through the leaves; the density differs from scene
    to scene.
    """
    rng = np.random.default_rng([seed, int(vegetated)])
    elevation = np.radians(np.arange(-15.0, 16.0, 2.0))
    azimuth = np.radians(np.arange(0.0, 360.0, 0.2))
    el, az = (grid.reshape(-1) for grid in np.meshgrid(elevation, azimuth))
    ring = np.tile(np.arange(16, dtype=np.uint16), len(azimuth))
    direction = np.column_stack([np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)])
    origin = np.array([0.0, 0.0, 0.7])
    distance: Floats = np.where(direction[:, 2] < 0, -origin[2] / np.minimum(direction[:, 2], -1e-9), np.inf)
    kind: NDArray[np.int64] = np.full(len(distance), STRUCTURE)
    places = rng.uniform(3.0, 20.0, 25), rng.uniform(0.0, 2 * np.pi, 25)
    for radius, angle in zip(*places, strict=True):
        centre = np.array([radius * np.cos(angle), radius * np.sin(angle), 0.0])
        size = rng.uniform([0.6, 0.6, 1.0], [3.0, 3.0, 3.0]) if vegetated else _structure_size(rng)
        enter, leave = ray_box(origin, direction, centre, size)
        if vegetated:
            enter = enter + rng.exponential(rng.uniform(0.3, 1.0), len(enter))
        hit = (enter < leave) & (enter < distance) & (leave > 0)
        distance = np.where(hit, enter, distance)
        kind = np.where(hit, VEGETATION if vegetated else STRUCTURE, kind)
    if vegetated:  # tall grass over all the ground
        top = rng.uniform(0.2, 0.5)
        reach_grass = np.where(direction[:, 2] < 0, (origin[2] - top) / np.maximum(-direction[:, 2], 1e-9), np.inf)
        end = reach_grass + rng.exponential(rng.uniform(0.5, 2.0), len(distance))
        kind = np.where(end < distance, VEGETATION, kind)
        distance = np.minimum(distance, end)
    seen = (distance > 0.5) & (distance < 60.0)
    noisy = distance[seen] + rng.normal(0.0, 0.015, int(seen.sum()))
    xyz = (direction[seen] * noisy[:, None]).astype(np.float32)
    return LabelledCloud(xyz, ring[seen], kind[seen])


def _structure_size(rng: np.random.Generator) -> Floats:
    """A wall, a box or a pole."""
    shapes = np.array([[4.0, 0.3, 2.5], [1.5, 1.5, 1.2], [0.25, 0.25, 3.0]])
    size: Floats = shapes[rng.integers(len(shapes))] * rng.uniform(0.7, 1.3, 3)
    return size[[1, 0, 2]] if rng.random() < 0.5 else size


def ray_box(origin: Floats, direction: Floats, centre: Floats, size: Floats) -> tuple[Floats, Floats]:
    """Where rays enter and leave an upright box that stands on the ground; enter > leave where they miss it."""
    low, high = centre - size * [0.5, 0.5, 0.0], centre + size * [0.5, 0.5, 1.0]
    safe = np.where(np.abs(direction) < 1e-12, 1e-12, direction)
    first, second = (low - origin) / safe, (high - origin) / safe
    enter: Floats = np.minimum(first, second).max(axis=1)
    leave: Floats = np.maximum(first, second).min(axis=1)
    return enter, np.where(leave > 0, leave, -np.inf)


def rellis_scan() -> LabelledCloud | None:
    """The real scan with every return, or None where its files are absent."""
    data = Path(os.environ.get("NAVTOOL_DATA", ROOT.parent / "shared" / "data"))
    scan, labels = data / "lidar" / "rellis3d" / "000104.bin", data / "lidar" / "rellis3d" / "000104.label"
    if not (scan.is_file() and labels.is_file()):
        return None
    xyz = np.fromfile(scan, "<f4").reshape(-1, 4)[:, :3]
    label = np.fromfile(labels, "<u4")
    kind = np.full(len(label), NEITHER)
    kind[np.isin(label, RELLIS_STRUCTURE)] = STRUCTURE
    kind[np.isin(label, RELLIS_VEGETATION)] = VEGETATION
    # The file holds the scan column by column, 64 beams each.
    return LabelledCloud(xyz, np.tile(np.arange(64, dtype=np.uint16), len(xyz) // 64), kind)


def real_variants(scan: LabelledCloud) -> list[tuple[str, LabelledCloud]]:
    assert scan.ring is not None
    every_third = (scan.ring % 3 == 1) & (scan.ring >= 9) & (scan.ring < 57)
    thinned = LabelledCloud(scan.xyz[every_third], scan.ring[every_third] // 3, scan.kind[every_third])
    return [
        ("RELLIS-3D, 64 rings", scan),
        ("RELLIS-3D, 16 rings", thinned),
        ("RELLIS-3D, no rings", scan._replace(ring=None)),
    ]


def point_row(name: str, clouds: list[LabelledCloud]) -> Measured:
    """Single points of all clouds together."""
    ranked = {}
    for method in CloudFeatureMethod:
        parts = [known_points(cloud, method) for cloud in clouds]
        ranked[method] = Ranked(
            np.concatenate([part.score for _, part in parts]), np.concatenate([part.kind for _, part in parts])
        )
    return measured(name, "points", ranked)


def patch_row(name: str, cloud: LabelledCloud) -> Measured:
    """Patches of at least 15 known points, 90 % of one kind."""
    ranked = {}
    for method in CloudFeatureMethod:
        xy, points = known_points(cloud, method)
        sector = np.floor(np.degrees(np.arctan2(xy[:, 1], xy[:, 0])) / 5).astype(int)
        patch = sector * 100 + np.digitize(np.hypot(xy[:, 0], xy[:, 1]), PATCH_RINGS_M)
        means, kinds = [], []
        for place in np.unique(patch):
            here = patch == place
            share = points.kind[here].mean()
            if here.sum() >= 15 and not 0.1 < share < 0.9:
                means.append(points.score[here].mean())
                kinds.append(STRUCTURE if share > 0.5 else VEGETATION)
        ranked[method] = Ranked(np.array(means), np.array(kinds))
    return measured(name, "patches", ranked)


def known_points(cloud: LabelledCloud, method: CloudFeatureMethod) -> tuple[NDArray[np.float32], Ranked]:
    """Places of the points of known kind, and each one's part in r_point."""
    config = CloudReliabilityConfig(method=method, max_points=20_000)
    features = cloud_features(cloud.xyz, cloud.ring, config)
    score = config.edge_weight * features.edge + config.planar_weight * features.planar
    kind = cloud.kind[features.at]
    known = kind != NEITHER
    return cloud.xyz[features.at[known], :2], Ranked(score[known], kind[known])


def measured(data: str, level: str, ranked: dict[CloudFeatureMethod, Ranked]) -> Measured:
    kind = ranked[CloudReliabilityConfig().method].kind
    return Measured(
        data=data,
        level=level,
        auc={method: auc(ranks.score, ranks.kind) for method, ranks in ranked.items()},
        structured=int((kind == STRUCTURE).sum()),
        vegetated=int((kind == VEGETATION).sum()),
        mean_structured={method: float(r.score[r.kind == STRUCTURE].mean()) for method, r in ranked.items()},
        mean_vegetated={method: float(r.score[r.kind == VEGETATION].mean()) for method, r in ranked.items()},
    )


def auc(score: Floats, kind: NDArray[np.int64]) -> float:
    """The chance that a structured one scores above a vegetated one; ties count half."""
    positive = kind == STRUCTURE
    count = int(positive.sum())
    ranks = rankdata(score)
    return float((ranks[positive].sum() - count * (count + 1) / 2) / (count * (len(kind) - count)))


def report_rows(figures: list[Measured]) -> list[Row]:
    """Each method's AUC, the default's set against the best of the others, and the means on both sides."""
    default = CloudReliabilityConfig().method
    rows = []
    for item in figures:
        what = f"{item.data}, {item.level} ({item.structured} against {item.vegetated})"
        best = max(value for method, value in item.auc.items() if method is not default)
        for method, ours in item.auc.items():
            row = Row(what=f"{what}: {method}", ours=ours, unit="AUC")
            if method is default:
                row = replace(row, peer=best, ratio=ours / best, bar=1.0, holds=ours >= best)
            rows.append(row)
        for method, ours in item.mean_structured.items():
            peer = item.mean_vegetated[method]
            ratio = ours / peer
            rows.append(Row(what=f"{what}: {method}", ours=ours, peer=peer, ratio=ratio, unit="mean r_point"))
    return rows


def time_rows() -> list[Row]:
    """The time of each method on a full scan of 28,800 points."""
    scan = simulated_scan(0, vegetated=False)
    assert scan.ring is not None
    xyz, ring = np.resize(scan.xyz, (28_800, 3)), np.resize(scan.ring, 28_800)
    rows = []
    for method in CloudFeatureMethod:
        config = CloudReliabilityConfig(method=method)
        (seconds,) = median_seconds(partial(cloud_reliability, xyz, ring, config), rounds=20)
        what = f"{method}, 28,800 points, 16 rings"
        rows.append(Row(what=what, ours=1000 * seconds, unit="ms", bar=5.0, holds=seconds <= 0.005))
    return rows


if __name__ == "__main__":
    main()
