"""Statistics against direct computation; LeRobot's own stand in test_lerobot_oracle.py."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from navtool.datasets.store.stats import ImageStats, aggregate, column_stats


@settings(deadline=None)
@given(st.lists(st.integers(1, 20), min_size=1, max_size=5), st.integers(0, 1000))
def test_aggregating_episodes_is_computing_over_all(lengths: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    parts = [rng.normal(size=(length, 2)) for length in lengths]
    merged = aggregate([{"x": column_stats(part)} for part in parts])["x"]
    whole = column_stats(np.concatenate(parts))
    for name in ("min", "max", "mean", "std", "count"):
        np.testing.assert_allclose(merged[name], whole[name], atol=1e-9)


def test_image_stats_are_those_of_the_thinned_pixels() -> None:
    rng = np.random.default_rng(1)
    frames = [rng.integers(0, 256, (240, 320, 3), dtype=np.uint8) for _ in range(3)]
    stats = ImageStats()
    for frame in frames:
        stats.add(frame)
    pixels = np.concatenate([frame[::4, ::4].reshape(-1, 3) for frame in frames]) / 255
    found = stats.result()
    assert np.array(found["mean"]).shape == (3, 1, 1)
    np.testing.assert_allclose(np.ravel(found["mean"]), pixels.mean(axis=0), atol=1e-9)
    np.testing.assert_allclose(np.ravel(found["std"]), pixels.std(axis=0), atol=1e-9)
    np.testing.assert_allclose(np.ravel(found["min"]), pixels.min(axis=0))
    np.testing.assert_allclose(np.ravel(found["max"]), pixels.max(axis=0))
    np.testing.assert_allclose(np.ravel(found["q50"]), np.quantile(pixels, 0.5, axis=0), atol=1 / 255)
    assert found["count"] == [3]


def test_nothing_counted_gives_zeros() -> None:
    found = ImageStats().result()
    assert found["count"] == [0]
    assert not np.any(found["mean"])
    merged = aggregate([{"x": found}, {"x": found}])["x"]
    assert merged["count"] == [0]
