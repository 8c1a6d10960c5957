"""The closed form against LAPACK, also where eigenvalues meet."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.pipeline.eigenvalues import symmetric_eigenvalues

# Beside an entry of 1e-159, LAPACK itself is off by 1e-6.
entry = st.floats(-1000, 1000).map(lambda value: round(value, 6))
entries = st.lists(entry, min_size=6, max_size=6).map(np.array)


def by_lapack(upper: NDArray[np.float64]) -> NDArray[np.float64]:
    xx, xy, xz, yy, yz, zz = upper
    return np.linalg.eigvalsh(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]))[::-1]


@settings(deadline=None)
@given(upper=entries)
def test_agrees_with_lapack(upper: NDArray[np.float64]) -> None:
    ours = symmetric_eigenvalues(upper[:, None])[:, 0]
    np.testing.assert_allclose(ours, by_lapack(upper), atol=2e-8 * np.abs(upper).max() + 1e-150, rtol=0)


@pytest.mark.parametrize(
    "diagonal", [[0, 0, 0], [2, 2, 2], [5, 5, 1], [5, 1, 1], [1, 0, 0], [1, 1e-12, 0], [-3, -3, -3]]
)
def test_meeting_eigenvalues(diagonal: list[float]) -> None:
    a, b, c = diagonal
    ours = symmetric_eigenvalues(np.array([[a, 0, 0, b, 0, c]], np.float64).T)[:, 0]
    np.testing.assert_allclose(ours, sorted(diagonal, reverse=True), atol=1e-7)


def test_whole_batches_and_float32() -> None:
    upper = np.random.default_rng(2).normal(size=(6, 40, 3))
    ours = symmetric_eigenvalues(upper.astype(np.float32))
    assert ours.shape == (3, 40, 3)
    assert ours.dtype == np.float64
    np.testing.assert_allclose(ours[:, 7, 2], by_lapack(upper[:, 7, 2]), atol=1e-5)
