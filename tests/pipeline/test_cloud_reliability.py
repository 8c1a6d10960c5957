"""Cloud reliability: plain formulas as oracles, shapes of known answer, degenerate clouds, a real labelled scan."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from navtool.base.setting_error import SettingError
from navtool.pipeline.cloud_neighbourhoods import nearest_neighbourhoods
from navtool.pipeline.cloud_reliability import (
    CloudFeatureMethod,
    CloudReliability,
    CloudReliabilityConfig,
    cloud_features,
    cloud_reliability,
)

Cloud = NDArray[np.float32]
Rings = NDArray[np.uint16]

NOTHING = CloudReliability(0.0, 0.0, 0.0)
DEFAULT = CloudReliabilityConfig()
ELEVATIONS = np.radians(np.arange(-15.0, 16.0, 2.0))
AZIMUTHS = np.radians(np.arange(-179.75, 180.0, 0.5))


def scan(distance: NDArray[np.float64]) -> tuple[Cloud, Rings]:
    """The returns of 16 rings, one a cell of half a degree, at the given distances (16, 720); infinite is no return."""
    el, az = ELEVATIONS[:, None], AZIMUTHS
    direction = np.stack(np.broadcast_arrays(np.cos(el) * np.cos(az), np.cos(el) * np.sin(az), np.sin(el)), axis=-1)
    seen = np.isfinite(distance)
    ring = np.broadcast_to(np.arange(16, dtype=np.uint16)[:, None], seen.shape)
    return (direction[seen] * distance[seen][:, None]).astype(np.float32), ring[seen]


def room(noise_m: float = 0.01, seed: int = 0) -> NDArray[np.float64]:
    """The distances of a square room of 12 m with a floor 0.8 m below the sensor and without a ceiling."""
    wall = 6.0 / np.maximum(np.abs(np.cos(AZIMUTHS)), np.abs(np.sin(AZIMUTHS)))[None] / np.cos(ELEVATIONS)[:, None]
    floor = np.where(ELEVATIONS < 0, 0.8 / np.maximum(-np.sin(ELEVATIONS), 1e-9), np.inf)[:, None]
    return np.asarray(np.minimum(wall, floor) + np.random.default_rng(seed).normal(0, noise_m, wall.shape))


def thicket(seed: int = 0) -> NDArray[np.float64]:
    """The distances of leaves everywhere from 2 m on."""
    return 2.0 + np.random.default_rng(seed).exponential(1.0, (16, 720))


@pytest.fixture(params=list(CloudFeatureMethod))
def config(request: pytest.FixtureRequest) -> CloudReliabilityConfig:
    return CloudReliabilityConfig(method=request.param)


def test_a_room_is_reliable_and_a_thicket_is_not() -> None:
    structured, scattered = cloud_reliability(*scan(room()), DEFAULT), cloud_reliability(*scan(thicket()), DEFAULT)
    assert structured.edge + structured.planar > 0.95
    assert scattered.edge + scattered.planar < 0.25
    # The planner's threshold r_th of the paper's Table V lies between them.
    assert structured.cloud > 0.43
    assert scattered.cloud < 0.15
    without_rings = [cloud_reliability(scan(distances)[0], None, DEFAULT).cloud for distances in (room(), thicket())]
    assert without_rings[0] > 0.4 > without_rings[1] + 0.2


def planar_scan(distance: NDArray[np.float64]) -> tuple[Cloud, Rings]:
    """A planar scanner's returns, evenly around."""
    azimuth = np.linspace(-np.pi, np.pi, len(distance), endpoint=False)
    xyz = np.column_stack([distance * np.cos(azimuth), distance * np.sin(azimuth), np.zeros(len(distance))])
    return xyz.astype(np.float32), np.zeros(len(distance), np.uint16)


@pytest.mark.parametrize("beams", [360, 720, 1081, 1440])
@pytest.mark.parametrize("method", list(CloudFeatureMethod))
def test_a_planar_scan_of_walls_is_more_reliable_than_one_of_scatter(beams: int, method: CloudFeatureMethod) -> None:
    rng = np.random.default_rng(8)
    config = CloudReliabilityConfig(method=method)
    walls = 6.0 / np.maximum(*np.abs([np.cos(angles := np.linspace(-np.pi, np.pi, beams)), np.sin(angles)]))
    values = [
        cloud_reliability(*planar_scan(walls + rng.exponential(scatter_m, beams)), config)
        for scatter_m in (0.01, 0.3, 1.0, 3.0)
    ]
    clouds = [value.cloud for value in values]
    assert clouds == sorted(clouds, reverse=True)
    assert clouds[0] > 0.35
    assert clouds[-1] < 0.05
    if method is CloudFeatureMethod.dimensionality:
        assert all(value.planar == 0 for value in values), "a single ring meets a surface in a line"


@settings(deadline=None, max_examples=60)
@given(distance=st.lists(st.floats(0, 100, width=32), max_size=60), method=st.sampled_from(CloudFeatureMethod))
def test_any_planar_scan_is_within_bounds_and_without_warnings(
    distance: list[float], method: CloudFeatureMethod
) -> None:
    cloud, edge, planar = cloud_reliability(
        *planar_scan(np.array(distance, np.float64)), CloudReliabilityConfig(method=method, min_neighbours=2)
    )
    assert 0 <= edge <= 1
    assert 0 <= planar <= 1
    assert cloud == pytest.approx(0.55 * edge + 0.45 * planar)


def test_the_lines_of_a_rosette_are_not_taken_for_rings(config: CloudReliabilityConfig) -> None:
    for distances in (room(), thicket()):
        xyz, _ = scan(distances)
        order = np.random.default_rng(9).permutation(len(xyz))
        lines = (np.arange(len(xyz)) % 4).astype(np.uint16)
        assert cloud_reliability(xyz[order], lines, config) == cloud_reliability(xyz[order], None, config)


def test_the_more_scatter_the_less_reliable() -> None:
    rng = np.random.default_rng(1)
    leaves = rng.random((16, 720))
    values = []
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        distances = np.where(leaves < share, np.minimum(room(), thicket()), room())
        values.append(cloud_reliability(*scan(distances), DEFAULT).cloud)
    assert values == sorted(values, reverse=True)
    assert values[0] > 2 * values[-1]


def test_a_wall_is_planar_and_a_wire_is_an_edge() -> None:
    rng = np.random.default_rng(2)
    wall = np.column_stack([np.full(2000, 4.0), rng.uniform(-2, 2, 2000), rng.uniform(-1, 1, 2000)])
    wire = np.column_stack([np.linspace(-5, 5, 2000), np.full(2000, 3.0), np.full(2000, 0.5)])
    noise = rng.normal(0, 0.002, (2000, 3))
    on_wall = cloud_reliability((wall + noise).astype(np.float32), None, DEFAULT)
    on_wire = cloud_reliability((wire + 0.1 * noise).astype(np.float32), None, DEFAULT)
    assert on_wall.planar > 0.9
    assert on_wire.edge > 0.95


def test_dimensionality_agrees_with_covariances_by_numpy() -> None:
    xyz = np.random.default_rng(3).normal(size=(300, 3)).astype(np.float32) + np.float32(5)
    features = cloud_features(xyz, None, DEFAULT)
    for place, edge, planar in zip(features.at, features.edge, features.planar, strict=True):
        nearest = np.argsort(np.linalg.norm(xyz - xyz[place], axis=1))[: DEFAULT.neighbours + 1]
        sigma = np.sqrt(np.linalg.eigvalsh(np.cov(xyz[nearest].T.astype(np.float64), bias=True)))[::-1]
        shape = np.argmax([sigma[0] - sigma[1], sigma[1] - sigma[2], sigma[2]])
        assert (edge, planar) == (shape == 0, shape == 1)


@pytest.mark.parametrize("method", [CloudFeatureMethod.loam, CloudFeatureMethod.loam_spread])
def test_smoothness_agrees_with_equation_3(method: CloudFeatureMethod) -> None:
    rng = np.random.default_rng(4)
    xyz = (rng.normal(size=(300, 3)) * [3, 3, 0.3]).astype(np.float32)
    # Thresholds amid the values, so that every class has members.
    config = CloudReliabilityConfig(method=method, c_min=0.1, c_max=0.2, neighbours=8)
    features = cloud_features(xyz, None, config)
    expected = []
    for place in features.at:
        point = xyz[place].astype(np.float64)
        nearest = xyz[np.argsort(np.linalg.norm(xyz - xyz[place], axis=1))[1:9]]
        offsets = point - nearest
        scale = np.linalg.norm(point) if method is CloudFeatureMethod.loam else np.linalg.norm(offsets, axis=1).mean()
        expected.append(np.linalg.norm(offsets.sum(axis=0)) / (scale * len(nearest)))
    np.testing.assert_array_equal(features.edge, np.array(expected) >= 0.2)
    np.testing.assert_array_equal(features.planar, np.array(expected) <= 0.1)
    assert features.edge.any()
    assert features.planar.any()


def test_spread_smoothness_never_leaves_the_unit_interval() -> None:
    xyz, ring = scan(thicket())
    at_most_one = CloudReliabilityConfig(method=CloudFeatureMethod.loam_spread, c_min=1.0, c_max=1.0, min_neighbours=2)
    features = cloud_features(xyz, ring, at_most_one)
    assert (features.planar | features.edge).mean() > 0.7  # all that have neighbours


@settings(deadline=None, max_examples=40)
@given(
    xyz=st.integers(0, 60).flatmap(lambda n: arrays(np.float32, (n, 3), elements=st.floats(-50, 50, width=32))),
    rings=st.integers(1, 4),
    with_rings=st.booleans(),
    method=st.sampled_from(CloudFeatureMethod),
)
def test_everything_is_within_bounds_and_adds_up(
    xyz: Cloud, rings: int, with_rings: bool, method: CloudFeatureMethod
) -> None:
    config = CloudReliabilityConfig(method=method, neighbours=5, min_neighbours=2)
    ring = (np.arange(len(xyz)) % rings).astype(np.uint16) if with_rings else None
    cloud, edge, planar = cloud_reliability(xyz, ring, config)
    assert 0 <= edge <= 1
    assert 0 <= planar <= 1
    assert edge + planar <= 1 + 1e-12
    assert cloud == pytest.approx(0.55 * edge + 0.45 * planar)


def test_returns_that_are_none_change_nothing(config: CloudReliabilityConfig) -> None:
    xyz, ring = scan(room())
    holes = np.full((500, 3), np.nan, np.float32)
    holes[:200] = 0
    holes[200:210] = [np.inf, -np.inf, 1.0]
    order = np.random.default_rng(5).permutation(len(xyz) + 500)
    padded, padded_ring = np.vstack([xyz, holes])[order], np.concatenate([ring, np.zeros(500, np.uint16)])[order]
    assert cloud_reliability(padded, padded_ring, config) == cloud_reliability(xyz, ring, config)


def test_order_scale_and_ring_numbers_change_nothing(config: CloudReliabilityConfig) -> None:
    xyz, ring = scan(room())
    whole = cloud_reliability(xyz, ring, config)
    order = np.random.default_rng(6).permutation(len(xyz))
    assert cloud_reliability(xyz[order], ring[order], config) == whole
    assert cloud_reliability(xyz, (65_535 - ring.astype(int)).astype(np.uint16), config) == whole
    # Neighbourhoods grow with the distance: a cloud four times as large looks the same.
    assert cloud_reliability(4 * xyz, ring, config) == whole
    assert cloud_reliability(xyz.astype(np.float64), ring, config) == whole


def test_turning_the_sensor_changes_little() -> None:
    turned = [cloud_reliability(*scan(np.roll(room(), shift, axis=1)), DEFAULT).cloud for shift in (0, 90, 333)]
    assert max(turned) - min(turned) < 0.02


@pytest.mark.parametrize("with_rings", [True, False])
@pytest.mark.parametrize(
    "xyz",
    [
        np.zeros((0, 3)),
        np.ones((1, 3)),
        np.ones((2, 3)),
        np.ones((500, 3)),
        np.zeros((500, 3)),
        np.full((500, 3), np.nan),
        np.full((500, 3), np.inf),
        np.arange(27.0).reshape(9, 3),
    ],
    ids=["none", "one", "two", "all equal", "no returns", "nan", "inf", "nine"],
)
def test_degenerate_clouds_are_not_reliable(
    xyz: NDArray[np.float64], with_rings: bool, config: CloudReliabilityConfig
) -> None:
    ring = np.zeros(len(xyz), np.uint16) if with_rings else None
    assert cloud_reliability(xyz.astype(np.float32), ring, config) == NOTHING


def test_points_on_one_line_of_sight_and_huge_clouds_do_not_break(config: CloudReliabilityConfig) -> None:
    along = np.outer(np.linspace(1, 9, 300), [1.0, 0.0, 0.0]).astype(np.float32)
    overhead = np.outer(np.linspace(1, 9, 300), [0.0, 0.0, 1.0]).astype(np.float32)
    for xyz in (along, overhead, along * np.float32(1e5), along.astype(np.float64) * 1e300):
        for ring in (None, np.zeros(300, np.uint16), np.arange(300, dtype=np.uint16)):
            assert 0 <= cloud_reliability(xyz, ring, config).cloud <= 0.55


def test_at_most_the_asked_number_of_points_is_looked_at() -> None:
    xyz, ring = scan(room())
    for rings in (ring, None):
        features = cloud_features(xyz, rings, CloudReliabilityConfig(max_points=100))
        assert 50 < len(features.at) <= 100
        assert len(np.unique(features.at)) == len(features.at)
        assert not (features.edge & features.planar).any()


def test_few_points_take_fewer_neighbours() -> None:
    xyz = np.random.default_rng(7).normal(size=(12, 3)).astype(np.float32)
    assert nearest_neighbourhoods(np.ascontiguousarray(xyz.T), 11, 6).size.tolist() == [11] * 6
    assert len(cloud_features(xyz, None, DEFAULT).at) == 12


@pytest.mark.parametrize(
    "bad",
    [
        {"c_max": 1.5},
        {"c_min": 0.7},
        {"edge_weight": -1.0},
        {"planar_weight": 2.0},
        {"reach": 0.0},
        {"neighbours": 2},
        {"min_neighbours": 1},
        {"max_points": 0},
    ],
)
def test_bad_settings_are_reported(bad: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=next(iter(bad))):
        CloudReliabilityConfig(**bad)  # type: ignore[arg-type] # the counts are ints


@pytest.mark.recordings
def test_a_real_scan_tells_ground_from_trees(recordings: Path) -> None:
    """RELLIS-3D's labelled Ouster scan: most of the ground is on features, most of the leaves are not."""
    xyz = np.fromfile(recordings / "lidar" / "rellis3d" / "000104.bin", "<f4").reshape(-1, 4)[:, :3]
    label = np.fromfile(recordings / "lidar" / "rellis3d" / "000104.label", "<u4")
    ring = np.tile(np.arange(64, dtype=np.uint16), len(xyz) // 64)
    every = CloudReliabilityConfig(max_points=20_000)
    features = cloud_features(xyz, ring, every)
    on_feature = features.edge | features.planar
    here = label[features.at]
    assert on_feature[np.isin(here, (3, 23, 31, 33))].mean() > 0.95  # grass, concrete, puddle, mud
    assert on_feature[np.isin(here, (4, 19))].mean() < 0.35  # tree, bush
    # The few points that are looked at by default stand for all.
    assert cloud_reliability(xyz, ring, DEFAULT).cloud == pytest.approx(
        cloud_reliability(xyz, ring, every).cloud, abs=0.02
    )
