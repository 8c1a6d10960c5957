"""Neighbourhoods: plain loops as the oracle."""

import numpy as np
import pytest
from numpy.typing import NDArray

from navtool.pipeline.cloud_neighbourhoods import (
    Neighbourhoods,
    nearest_neighbourhoods,
    ring_neighbourhoods,
    rings_are_level,
)

Columns = NDArray[np.float32]


def scan(rings: int = 16, step_deg: float = 2.0) -> tuple[Columns, NDArray[np.uint16]]:
    """Returns from random ranges in every grid cell's middle, with a tenth missing, and their rings."""
    rng = np.random.default_rng(0)
    ring, column = (grid.reshape(-1) for grid in np.meshgrid(np.arange(rings), np.arange(720), indexing="ij"))
    azimuth = (column + 0.5) * 2 * np.pi / 720 - np.pi
    elevation = np.radians((ring - rings / 2) * step_deg)
    distance = 5 + np.sin(3 * azimuth) + rng.uniform(0, 0.8, len(ring))
    kept = rng.random(len(ring)) < 0.9
    points = distance * [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    return points[:, kept].astype(np.float32), ring[kept].astype(np.uint16)


def neighbours_of(around: Neighbourhoods, row: int) -> set[tuple[float, ...]]:
    """The differences of one centre to its neighbours."""
    differences = around.difference[:, row].T
    return {tuple(d) for d in differences.tolist() if any(d)}


def test_ring_windows_hold_exactly_the_near_cells() -> None:
    points, ring = scan()
    around = ring_neighbourhoods(points, ring, reach=0.07, max_points=150)
    assert 100 < len(around.centre) <= 150
    column = np.floor(np.degrees(np.arctan2(points[1], points[0])) / 0.5).astype(int)
    for row, centre in enumerate(around.centre.tolist()):
        sideways = np.mod(column - column[centre] + 360, 720) - 360
        upward = ring.astype(int) - int(ring[centre])
        difference = points - points[:, [centre]]
        near = np.linalg.norm(difference, axis=0) <= 0.07 * np.linalg.norm(points[:, centre])
        chosen = (np.abs(sideways) <= 6) & (np.abs(upward) <= 2) & near
        chosen[centre] = False
        assert neighbours_of(around, row) == {tuple(d) for d in difference[:, chosen].T.tolist()}
        assert around.size[row] == chosen.sum()


def test_ring_numbers_only_name_the_rings() -> None:
    points, ring = scan()
    upside_down = (1000 - 7 * ring.astype(int)).astype(np.uint16)
    ours, theirs = (ring_neighbourhoods(points, numbers, 0.07, 200) for numbers in (ring, upside_down))
    np.testing.assert_array_equal(ours.centre, theirs.centre)
    np.testing.assert_array_equal(ours.difference, theirs.difference)


def test_dense_rings_are_thinned_to_the_step() -> None:
    points, ring = scan(rings=64, step_deg=0.5)
    around = ring_neighbourhoods(points, ring, reach=0.07, max_points=20_000)
    rows = np.unique(ring[around.centre]).astype(int)
    assert (np.diff(rows) * 0.5 >= 1.3).all()
    assert len(rows) == 22  # every third


def test_no_more_points_than_asked_for_and_all_around() -> None:
    points, ring = scan()
    around = ring_neighbourhoods(points, ring, reach=0.07, max_points=500)
    assert 250 < len(around.centre) <= 500
    sector = np.floor(np.degrees(np.arctan2(points[1], points[0])[around.centre]) / 30)
    assert np.unique(sector, return_counts=True)[1].min() > 15
    assert len(np.unique(ring[around.centre])) == 16


def test_rings_of_a_spinning_sensor_are_level_and_lines_of_a_rosette_are_not() -> None:
    points, ring = scan()
    assert rings_are_level(points, ring)
    assert rings_are_level(points, (65_535 - ring).astype(np.uint16))
    order = np.random.default_rng(1).permutation(len(ring))
    assert rings_are_level(points[:, order], ring[order])
    assert rings_are_level(points[:, ring == 15], ring[ring == 15])
    assert not rings_are_level(points, np.zeros_like(ring)), "one line that goes up and down"
    assert not rings_are_level(points[:, order], (np.arange(len(ring)) % 4).astype(np.uint16))
    assert rings_are_level(np.ones((3, 1), np.float32), np.zeros(1, np.uint16))
    assert not rings_are_level(points[:, :513], np.arange(513, dtype=np.uint16)), "more numbers than a LiDAR has lasers"
    assert rings_are_level(points[:, :512], 60_000 + np.arange(512, dtype=np.uint16))


@pytest.mark.parametrize("columns", [1, 2])
def test_a_ring_of_few_points(columns: int) -> None:
    points, ring = np.ones((3, columns), np.float32), np.zeros(columns, np.uint16)
    around = ring_neighbourhoods(points, ring, reach=0.07, max_points=10)
    assert len(around.centre) == 1  # one cell holds one point
    assert around.size.tolist() == [0]


def test_nearest_neighbours_are_the_nearest() -> None:
    points = np.random.default_rng(3).normal(size=(3, 400)).astype(np.float32)
    around = nearest_neighbourhoods(points, neighbours=12, max_points=50)
    assert len(around.centre) == 50
    assert (around.size == 12).all()
    for row, centre in enumerate(around.centre.tolist()):
        distances = np.sort(np.linalg.norm(points - points[:, [centre]], axis=0))[1:13]
        ours = np.sort(np.linalg.norm(around.difference[:, row], axis=0))[-12:]
        np.testing.assert_allclose(ours, distances, rtol=1e-6)
