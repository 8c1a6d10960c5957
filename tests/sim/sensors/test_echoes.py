import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.pipeline.arrays import Array
from navtool.sim.sensors.echoes import beam_share, find_echoes

OFFSETS = (np.arange(-2, 3) * 1.7e-3).astype(np.float32)
PULSE_M, FAINTEST, GAP_M = 0.3, np.float32(4e-5), 1.0


def beams(seed: int, rows: int = 40) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    ranges = rng.uniform(0.6, 60, (rows, 1)) + rng.choice([0, 0.1, 0.5, 2, 8], (rows, 5)) * rng.random((rows, 5))
    ranges[rng.random((rows, 5)) < 0.2] = np.inf
    return ranges.astype(np.float32), (0.2 * rng.random((rows, 5)) ** 2).astype(np.float32)


@given(st.floats(0.3, 100))
def test_a_beam_spends_its_light_once(distance: float) -> None:
    share = beam_share(OFFSETS, 1.7e-3, np.full((1, 5), distance, np.float32), 3.0e-3, 0.0127)
    assert share.sum() == pytest.approx(1.0, abs=1e-4)
    assert (share >= 0).all()
    assert share[0, 2] >= share.max() - 1e-6
    assert share[0] == pytest.approx(share[0, ::-1])


def test_a_beam_is_narrower_in_angle_the_farther_away() -> None:
    shares = [
        float(beam_share(OFFSETS, 1.7e-3, np.full((1, 5), r, np.float32), 3.0e-3, 0.0127)[0, 2]) for r in (1, 3, 9, 50)
    ]
    assert shares == sorted(shares)
    assert shares[0] < 0.25
    assert shares[-1] > 0.5


@settings(deadline=None)
@given(st.integers(0, 10**6))
def test_echoes_are_those_of_a_plain_loop(seed: int) -> None:
    ranges, strengths = beams(seed)
    strongest, last, second = find_echoes(ranges, strengths, FAINTEST * ranges**2, PULSE_M, GAP_M)
    for row in range(len(ranges)):
        peaks = []
        for j in range(5):
            if not np.isfinite(ranges[row, j]) or strengths[row, j] == 0:
                continue
            overlap = [
                0.0
                if not np.isfinite(ranges[row, k])
                else float(strengths[row, k]) * np.exp(-((ranges[row, j] - ranges[row, k]) ** 2) / (2 * PULSE_M**2))
                for k in range(5)
            ]
            total = sum(overlap)
            centre = sum(o * float(r) for o, r in zip(overlap, ranges[row], strict=True) if o) / total
            if total >= FAINTEST * float(ranges[row, j]) ** 2 * (1 + 1e-5):
                peaks.append((total, centre))
        if not peaks:
            continue
        best = max(peaks)
        assert strongest.strength[row] == pytest.approx(best[0], rel=1e-4)
        assert last.range_m[row] == pytest.approx(max(centre for _, centre in peaks), rel=1e-3)
        others = [peak for peak in peaks if abs(peak[1] - strongest.range_m[row]) >= GAP_M * 1.001]
        if others:
            assert second.strength[row] == pytest.approx(max(others)[0], rel=1e-3)


@settings(deadline=None)
@given(st.integers(0, 10**6))
def test_no_echo_is_stronger_than_all_the_light_that_returns(seed: int) -> None:
    ranges, strengths = beams(seed)
    total = np.where(np.isfinite(ranges), strengths, 0).sum(axis=1)
    for echoes in find_echoes(ranges, strengths, FAINTEST * ranges**2, PULSE_M, GAP_M):
        assert (echoes.strength <= total * (1 + 1e-5)).all()
        found = np.isfinite(echoes.range_m)
        assert (echoes.strength[found] > 0).all()
        assert (echoes.strength[~found] == 0).all()


def test_nothing_returns_nothing() -> None:
    for echoes in find_echoes(
        np.full((3, 5), np.inf, np.float32), np.zeros((3, 5), np.float32), np.ones((3, 5), np.float32), PULSE_M, GAP_M
    ):
        assert np.isinf(echoes.range_m).all()
