"""The fixed-size cloud: a slow, plain form as the oracle, and what it promises about order, seed and size."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from numpy.typing import NDArray

from navtool.pipeline.downsample import MAX_RANGE_M, FixedSizeCloud, fixed_size_cloud, valid_returns

Floats = NDArray[np.float32]

coordinates = st.one_of(
    st.floats(-40, 40, width=32),
    st.floats(-0.25, 0.25, width=32),
    st.sampled_from([0.0, -0.0, np.nan, np.inf, -np.inf]),
)
clouds = st.integers(0, 60).flatmap(lambda n: arrays(np.float32, (n, 3), elements=coordinates))


def cloud_of(n: int, seed: int = 0) -> Floats:
    rng = np.random.default_rng(seed)
    return np.asarray(rng.normal(size=(n, 3)) * [12, 12, 1.5], np.float32)


def places(cloud: FixedSizeCloud) -> set[tuple[int, ...]]:
    """The points in whole millimetres."""
    millimetres = np.rint(cloud.points[: cloud.kept].astype(np.float64) * 1000).astype(int)
    return {tuple(row) for row in millimetres.tolist()}


def front_places(xyz: Floats) -> set[tuple[int, ...]]:
    """Every point that may stay, in whole millimetres, one by one."""
    found: set[tuple[int, ...]] = set()
    for x, y, z in xyz.astype(np.float64).tolist():
        if np.isfinite([x, y, z]).all() and x >= 0 and (x, y, z) != (0, 0, 0):
            found.add((round(x * 1000), round(y * 1000), round(z * 1000)))
    return found


def voxel_of(place: tuple[int, ...], voxel_mm: int) -> tuple[int, ...]:
    return tuple(value // voxel_mm for value in place)


@settings(deadline=None)
@given(xyz=clouds, voxel_mm=st.sampled_from([1, 7, 50, 1000]), seed=st.integers(0, 2**63))
def test_one_real_point_of_every_voxel_in_front_stays(xyz: Floats, voxel_mm: int, seed: int) -> None:
    cloud = fixed_size_cloud(xyz, size=100, seed=seed, voxel_m=voxel_mm / 1000)
    kept, possible = places(cloud), front_places(xyz)
    assert kept <= possible
    assert {voxel_of(place, voxel_mm) for place in kept} == {voxel_of(place, voxel_mm) for place in possible}
    assert cloud.kept == len(kept) == len({voxel_of(place, voxel_mm) for place in possible})


@settings(deadline=None)
@given(xyz=clouds, size=st.integers(1, 30))
def test_the_rest_repeats_the_points_and_the_count_is_exact(xyz: Floats, size: int) -> None:
    cloud = fixed_size_cloud(xyz, size=size, voxel_m=0.05)
    everything = fixed_size_cloud(xyz, size=100, voxel_m=0.05)
    assert cloud.points.shape == (size, 3)
    assert cloud.points.dtype == np.float32
    assert cloud.kept == min(size, everything.kept)
    np.testing.assert_array_equal(cloud.points, np.resize(cloud.points[: cloud.kept], (size, 3)))
    assert places(cloud) <= places(everything)
    assert (cloud.points[:, 0] >= 0).all()


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 1000), shuffle=st.integers(0, 1000))
def test_the_order_of_the_points_changes_nothing(seed: int, shuffle: int) -> None:
    xyz = cloud_of(900, seed)
    shuffled = np.random.default_rng(shuffle).permutation(xyz)
    ours, theirs = fixed_size_cloud(xyz, 200, 5, 0.2), fixed_size_cloud(shuffled, 200, 5, 0.2)
    np.testing.assert_array_equal(ours.points, theirs.points)
    doubled = fixed_size_cloud(np.vstack([xyz, shuffled]), 200, 5, 0.2)
    np.testing.assert_array_equal(ours.points, doubled.points)


def test_the_seed_chooses_evenly() -> None:
    xyz = cloud_of(3000)
    first, again, other = (fixed_size_cloud(xyz, 400, seed, 0.05) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first.points, again.points)
    assert places(first) != places(other)
    # Over many seeds each voxel stays about as often as any other.
    counts: dict[tuple[int, ...], int] = {}
    for seed in range(200):
        for place in places(fixed_size_cloud(xyz[:300], 50, seed, 0.001)):
            counts[place] = counts.get(place, 0) + 1
    share = 50 / len(front_places(xyz[:300]))
    assert abs(np.mean(list(counts.values())) / 200 - share) < 0.01
    assert max(counts.values()) < 200 * share + 5 * np.sqrt(200 * share)


def test_no_corner_of_a_voxel_is_preferred() -> None:
    rng = np.random.default_rng(4)
    xyz = rng.uniform([0, -20, -2], [40, 20, 2], (200_000, 3)).astype(np.float32)
    cloud = fixed_size_cloud(xyz, size=10_000, voxel_m=1.0)
    within = np.mod(cloud.points[: cloud.kept], 1.0)
    np.testing.assert_allclose(within.mean(axis=0), 0.5, atol=0.03)


def test_points_are_whole_millimetres_near_the_measured_ones() -> None:
    xyz = cloud_of(500)
    cloud = fixed_size_cloud(xyz, 1000, 0, 0.001)
    millimetres = cloud.points.astype(np.float64) * 1000
    np.testing.assert_allclose(millimetres, np.rint(millimetres), atol=0.01)
    nearest = np.abs(cloud.points[: cloud.kept, None] - xyz[None]).max(axis=2).min(axis=1)
    assert nearest.max() < 0.00051


def test_far_and_unreal_points_are_dropped() -> None:
    inf, nan = np.inf, np.nan
    xyz = np.array(
        [[0, 0, 0], [nan, 1, 1], [1, inf, 1], [1, 1, -inf], [-1, 0, 0], [2 * MAX_RANGE_M, 0, 0], [5, 0, 0]], np.float32
    )
    cloud = fixed_size_cloud(xyz, size=4)
    assert cloud.kept == 1
    np.testing.assert_array_equal(cloud.points, [[5, 0, 0]] * 4)
    assert not fixed_size_cloud(xyz[:-1], size=4).points.any()
    np.testing.assert_array_equal(valid_returns(xyz), [False, False, False, False, True, True, True])


@pytest.mark.parametrize("voxel_mm", [1, 7, 50, 1025, 8196, 10_000])
def test_points_at_the_end_of_the_range_stay_as_they_are(voxel_mm: int) -> None:
    """The largest numbers that points and voxels are packed into; 8196 mm takes the most."""
    ends = np.array([[x, y, z] for x in (0, MAX_RANGE_M) for y in (-1, 1) for z in (-1, 1)], np.float32)
    ends[:, 1:] *= np.float32(MAX_RANGE_M)
    assert places(fixed_size_cloud(ends, 8, 0, voxel_mm / 1000)) == front_places(ends)


def test_a_planar_scan_stays_planar_with_one_point_a_voxel() -> None:
    angle = np.radians(np.arange(-135, 135.25, 0.25))
    distance = 2.0 + np.random.default_rng(5).exponential(3.0, len(angle))
    xyz = np.column_stack([distance * np.cos(angle), distance * np.sin(angle), np.full(len(angle), 0.3)])
    cloud = fixed_size_cloud(xyz.astype(np.float32))
    possible = front_places(xyz.astype(np.float32))
    assert places(cloud) <= possible
    assert cloud.kept == len({voxel_of(place, 50) for place in possible})
    assert (cloud.points[:, 2] == np.float32(0.3)).all(), "what fills up repeats the scan, it is not in another plane"


def test_float64_clouds_and_negative_zero() -> None:
    xyz = np.array([[-0.0, 1.0004, 0.0], [1e-9, 2.0, 0.0]])
    assert places(fixed_size_cloud(xyz, 5)) == {(0, 1000, 0), (0, 2000, 0)}


@pytest.mark.parametrize(
    ("size", "seed", "voxel_m"), [(0, 0, 0.05), (5, -1, 0.05), (5, 0, 0.0), (5, 0, 0.0505), (5, 0, 11.0)]
)
def test_bad_settings_are_reported(size: int, seed: int, voxel_m: float) -> None:
    with pytest.raises(ValueError, match="set"):
        fixed_size_cloud(cloud_of(3), size, seed, voxel_m)


@pytest.mark.recordings
def test_a_real_scan(recordings: Path) -> None:
    xyz = np.fromfile(recordings / "lidar" / "rellis3d" / "vel000104.bin", "<f4").reshape(-1, 4)[:, :3]
    cloud = fixed_size_cloud(xyz)
    assert cloud.kept == 10_000
    assert places(cloud) <= front_places(xyz)
