"""Glass is remembered in the odometry frame: it stays where it is, fades, and gives way to the robot alone."""

import numpy as np
import pytest
from numpy.typing import NDArray

from navtool.pipeline.intensity_map.config import GlassConfig, GridConfig
from navtool.pipeline.intensity_map.glass_memory import GlassMemory, remember_glass, transparent_cells

GRID, ONCE = GridConfig(), GlassConfig(clouds=1)
RADIUS_M = 0.4
NONE = np.zeros((0, 4), np.float32)
PANE = np.array([[3, -1, 3, 1]], np.float32)


def pose(x: float, y: float = 0.0, yaw: float = 0.0) -> NDArray[np.float64]:
    return np.array([x, y, yaw])


def after(
    memory: GlassMemory, segments: NDArray[np.float32], at: NDArray[np.float64], time_s: float, config: GlassConfig
) -> GlassMemory:
    return remember_glass(memory, segments, at, time_s, RADIUS_M, GRID, config)


def middles(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    return np.asarray((np.argwhere(mask) + 0.5 - GRID.cells / 2) * GRID.cell_m)


def test_a_pane_covers_its_cells_and_nothing_else() -> None:
    memory = after(GlassMemory(), PANE, pose(0), 0.0, ONCE)
    cells = middles(transparent_cells(memory, pose(0), GRID, ONCE))
    assert np.abs(cells[:, 0] - 3).max() <= GRID.cell_m
    assert np.abs(cells[:, 1]).max() <= 1 + GRID.cell_m
    assert len(np.unique(cells[:, 1])) >= 20, "without gaps"


@pytest.mark.parametrize("way", [(0.8, 0.0, 0.0), (0.5, 0.4, 0.7), (-0.3, 0.6, -2.0), (0.0, 0.0, 3.1)])
def test_a_pane_stays_where_it_is_while_the_robot_moves(way: tuple[float, float, float]) -> None:
    memory = after(GlassMemory(), PANE, pose(0), 0.0, ONCE)
    moved = np.array(way)
    memory = after(memory, NONE, moved, 1.0, ONCE)
    cells = middles(transparent_cells(memory, moved, GRID, ONCE))
    cosine, sine = np.cos(way[2]), np.sin(way[2])
    in_odometry = cells @ np.array([[cosine, sine], [-sine, cosine]]) + way[:2]
    assert len(cells) >= 20
    assert np.abs(in_odometry[:, 0] - 3).max() <= 1.5 * GRID.cell_m
    assert np.abs(in_odometry[:, 1]).max() <= 1 + 1.5 * GRID.cell_m
    # every place along the pane is covered
    for y in np.linspace(-1, 1, 50):
        assert np.hypot(*(in_odometry - (3, y)).T).min() <= GRID.cell_m


def test_a_pane_is_believed_after_so_many_clouds() -> None:
    config = GlassConfig(clouds=3)
    memory = GlassMemory()
    for k in range(3):
        assert not transparent_cells(memory, pose(0), GRID, config).any()
        memory = after(memory, PANE, pose(0), 0.1 * k, config)
    assert transparent_cells(memory, pose(0), GRID, config).any()


def test_glass_is_forgotten_after_its_time_and_kept_until_then() -> None:
    config = GlassConfig(clouds=1, decay_s=5.0)
    memory = after(GlassMemory(), PANE, pose(0), 10.0, config)
    assert after(memory, NONE, pose(0), 14.9, config).cell.size
    assert not after(memory, NONE, pose(0), 15.1, config).cell.size
    again = after(memory, PANE, pose(0), 14.0, config)
    assert after(again, NONE, pose(0), 18.9, config).cell.size, "seen again, remembered longer"


def test_only_the_own_way_clears_glass() -> None:
    memory = after(GlassMemory(), PANE, pose(0), 0.0, ONCE)
    standing = after(memory, NONE, pose(0), 1.0, ONCE)
    np.testing.assert_array_equal(standing.cell, memory.cell)
    # one step from 0.5 m before the pane to 0.45 m behind it: all that lies within the radius of the way is gone
    config = GlassConfig(clouds=1, jump_m=5.0)
    before = after(memory, NONE, pose(2.5), 2.0, config)
    behind = after(before, NONE, pose(3.45), 3.0, config)
    cells = middles(transparent_cells(behind, pose(3.45), GRID, config))
    assert np.abs(cells[:, 1]).min() > RADIUS_M - GRID.cell_m
    assert np.abs(cells[:, 1]).max() > 0.9, "the rest of the pane stands"


def test_a_jump_of_the_pose_or_of_time_forgets_and_counts() -> None:
    memory = after(GlassMemory(), PANE, pose(0), 10.0, ONCE)
    config = GlassConfig(clouds=1, jump_m=1.0, fastest_mps=2.0)
    for at, time_s in ((pose(1.1), 10.1), (pose(0, -2.9), 11.0), (pose(20.0), 20.0)):
        assert after(memory, NONE, at, time_s, config).jumps == 0, "it can have driven there"
    for at, time_s in ((pose(1.3), 10.1), (pose(0, -3.1), 11.0), (pose(0), 9.9)):
        jumped = after(memory, NONE, at, time_s, config)
        assert jumped.jumps == 1
        assert not jumped.cell.size
    assert not after(jumped, NONE, pose(0), 10.5, ONCE).cell.size
    assert after(jumped, NONE, pose(0), 10.5, ONCE).jumps == 1


@pytest.mark.parametrize(("at", "time_s"), [(pose(np.nan), 0.0), (pose(0, 0, np.inf), 0.0), (pose(0), np.nan)])
def test_a_pose_that_is_not_finite_is_refused(at: NDArray[np.float64], time_s: float) -> None:
    with pytest.raises(ValueError, match="finite"):
        after(GlassMemory(), PANE, at, time_s, ONCE)


def test_the_memory_it_was_given_is_left_as_it_is() -> None:
    memory = after(GlassMemory(), PANE, pose(0), 0.0, ONCE)
    cell, clouds, seen = memory.cell.copy(), memory.clouds.copy(), memory.seen_s.copy()
    after(memory, PANE, pose(0.1), 0.1, ONCE)
    for kept, left in ((cell, memory.cell), (clouds, memory.clouds), (seen, memory.seen_s)):
        np.testing.assert_array_equal(kept, left)


@pytest.mark.slow
def test_the_memory_stays_flat_over_twenty_thousand_clouds_of_a_moving_robot() -> None:
    rng = np.random.default_rng(0)
    memory, sizes = GlassMemory(), []
    for k in range(20_000):
        time_s = 0.1 * k
        at = pose(0.08 * k, 3 * np.sin(0.01 * k), 0.02 * k)
        start, angle = rng.uniform(-5, 5, 2), rng.uniform(0, np.pi)
        segment = np.array([[*start, *(start + 1.5 * np.array([np.cos(angle), np.sin(angle)]))]], np.float32)
        memory = after(memory, segment, at, time_s, GlassConfig(decay_s=30.0))
        sizes.append(memory.cell.size)
    assert memory.jumps == 0
    # 15 m around the robot at most, and 30 s of panes of 1.5 m: 300 clouds of up to 2 x 31 cells
    assert max(sizes) < 300 * 62
    early, late = np.mean(sizes[1000:2000]), np.mean(sizes[-1000:])
    assert late == pytest.approx(early, rel=0.1)
