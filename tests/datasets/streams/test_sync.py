"""Laws of the grid and of the three ways to bring a stream onto it."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from navtool.datasets.streams.sync import Method, around_ticks, brackets, choose, grid_ticks, hold, nearest

stamps = st.lists(st.integers(0, 5_000_000_000), min_size=1, max_size=60, unique=True).map(
    lambda values: np.array(sorted(values), dtype=np.int64)
)
tick_lists = st.lists(st.integers(-1_000_000_000, 6_000_000_000), min_size=1, max_size=40).map(
    lambda values: np.array(sorted(values), dtype=np.int64)
)


@given(st.integers(0, 2**61), st.integers(0, 100_000_000_000), st.integers(1, 60))
def test_grid_is_even_and_inside(start_ns: int, length_ns: int, fps: int) -> None:
    ticks = grid_ticks(start_ns, start_ns + length_ns, fps)
    assert ticks[0] == start_ns
    assert ticks[-1] <= start_ns + length_ns < ticks[-1] + 1_000_000_000 // fps + 1
    spacing = np.diff(ticks)
    assert spacing.size == 0 or (np.abs(spacing - 1e9 / fps) <= 1).all()


@given(stamps, tick_lists, st.floats(0.0, 2.0))
def test_nearest_equals_exhaustive_search(
    samples: np.ndarray[tuple[int], np.dtype[np.int64]],
    ticks: np.ndarray[tuple[int], np.dtype[np.int64]],
    tolerance_s: float,
) -> None:
    match = nearest(samples, ticks, tolerance_s)
    distance = np.abs(samples[None, :] - ticks[:, None])
    best = distance.min(axis=1)
    assert (match.valid == (best <= round(tolerance_s * 1e9))).all()
    chosen = match.index[match.valid]
    assert (distance[np.flatnonzero(match.valid), chosen] == best[match.valid]).all()
    assert (chosen == distance.argmin(axis=1)[match.valid]).all()
    np.testing.assert_allclose(match.error_s[match.valid], (samples[chosen] - ticks[match.valid]) * 1e-9)
    assert (match.index[~match.valid] == -1).all()


@given(stamps, tick_lists, st.floats(0.0, 2.0))
def test_hold_never_looks_ahead(
    samples: np.ndarray[tuple[int], np.dtype[np.int64]],
    ticks: np.ndarray[tuple[int], np.dtype[np.int64]],
    tolerance_s: float,
) -> None:
    match = hold(samples, ticks, tolerance_s)
    for tick, index, valid in zip(ticks, match.index, match.valid, strict=True):
        past = np.flatnonzero(samples <= tick)
        expected = past.size > 0 and tick - samples[past[-1]] <= round(tolerance_s * 1e9)
        assert valid == expected
        assert index == (past[-1] if expected else -1)


@given(stamps, tick_lists, st.floats(0.0, 2.0))
def test_linear_interpolation_reproduces_a_line(
    samples: np.ndarray[tuple[int], np.dtype[np.int64]],
    ticks: np.ndarray[tuple[int], np.dtype[np.int64]],
    max_gap_s: float,
) -> None:
    around = brackets(samples, ticks, max_gap_s)
    line = 3.0 + 0.5e-9 * samples.astype(np.float64)
    np.testing.assert_allclose(
        around.linear(line)[around.valid], 3.0 + 0.5e-9 * ticks[around.valid].astype(np.float64), atol=1e-9
    )
    assert (ticks[around.valid] >= samples[0]).all()
    assert (ticks[around.valid] <= samples[-1]).all()
    gaps = samples[around.after] - samples[around.before]
    assert (gaps[around.valid] <= round(max_gap_s * 1e9)).all()


@given(stamps, tick_lists, st.floats(0.0, 2.0), st.sampled_from(Method))
def test_values_come_from_the_samples_that_the_method_names(
    samples: np.ndarray[tuple[int], np.dtype[np.int64]],
    ticks: np.ndarray[tuple[int], np.dtype[np.int64]],
    tolerance_s: float,
    method: Method,
) -> None:
    values = np.sin(samples.astype(np.float64))
    around = around_ticks(method, samples, ticks, tolerance_s)
    given = around.linear(values)
    if method is Method.linear:
        np.testing.assert_array_equal(given, brackets(samples, ticks, tolerance_s).linear(values))
        return
    match = choose(method, samples, ticks, tolerance_s)
    np.testing.assert_array_equal(around.valid, match.valid)
    np.testing.assert_array_equal(around.error_s, match.error_s)
    np.testing.assert_array_equal(given, np.where(match.valid, values[match.index], 0.0))


def test_empty_streams_match_nothing() -> None:
    none = np.array([], dtype=np.int64)
    ticks = np.array([0, 1], dtype=np.int64)
    assert not nearest(none, ticks, 1.0).valid.any()
    assert not hold(none, ticks, 1.0).valid.any()
    assert not brackets(none, ticks, 1.0).valid.any()
