"""Which rows become samples: against a naive reading of the rules, row by row."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from navtool.base.setting_error import SettingError
from navtool.train.errors import TrainError
from navtool.train.success.windows import DataConfig, MissingModality, Windows, plan_windows
from navtool.train.synthetic import SyntheticConfig, SyntheticSource

CONFIG = DataConfig(history_steps=6, horizon_steps=4)


def patchy(seed: int) -> SyntheticSource:
    """Three episodes in which every stream and label is missing somewhere."""
    source = SyntheticSource(SyntheticConfig(rows=40, image_height=24, image_width=32))
    rng = np.random.default_rng(seed)
    for name in ("valid.camera", "valid.lidar", "valid.state"):
        source.columns[name] = rng.random(len(source)) < 0.93
    source.columns["label.known"] = rng.random((len(source), 10)) < 0.6
    return source


def flags(source: SyntheticSource, name: str) -> NDArray[np.bool_]:
    return source.column(name).astype(np.bool_)


def naive(source: SyntheticSource, episodes: list[int]) -> dict[int, list[tuple[bool, float]]]:
    """Row -> (known, outcome) of each step, for the rows that are samples."""
    image, lidar, state = (flags(source, f"valid.{name}") for name in ("camera", "lidar", "state"))
    known, outcome = flags(source, "label.known"), source.column("label.outcome")
    samples = {}
    for index in episodes:
        episode = source.episodes[index]
        for row in range(episode.start, episode.stop):
            history = [state[h] for h in range(row - 5, row + 1) if h >= episode.start]
            steps = []
            for k in range(4):
                step = row + k
                is_known = bool(step < episode.stop and known[row, k] and state[step])
                steps.append((is_known, float(outcome[step]) if is_known else 0.0))
            if all(history) and image[row] and lidar[row] and any(is_known for is_known, _ in steps):
                samples[row] = steps
    return samples


@given(st.integers(0, 2**32 - 1), st.lists(st.sampled_from([0, 1, 2]), unique=True, max_size=3))
@settings(max_examples=40, deadline=None)
def test_samples_targets_and_masks_equal_a_naive_loop(seed: int, episodes: list[int]) -> None:
    source = patchy(seed)
    windows = plan_windows(source, episodes, CONFIG)
    expected = naive(source, episodes)
    assert windows.row.tolist() == list(expected)
    assert [list(zip(*pair, strict=True)) for pair in zip(windows.known, windows.target, strict=True)] == list(
        expected.values()
    )


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=40, deadline=None)
def test_the_report_accounts_for_every_row_and_every_step(seed: int) -> None:
    source = patchy(seed)
    windows = plan_windows(source, [0, 1, 2], CONFIG)
    report = windows.report
    assert report.rows == len(source)
    assert report.samples + sum(report.excluded.values()) == report.rows
    assert report.positives + report.negatives == report.samples
    assert windows.known.sum() + sum(report.masked_steps.values()) == windows.known.size
    failed = [
        bool((~outcome[known].astype(np.bool_)).any())
        for known, outcome in zip(windows.known, windows.target, strict=True)
    ]
    assert report.negatives == sum(failed)


def test_a_clean_data_set_loses_nothing_but_its_last_steps() -> None:
    source = SyntheticSource(SyntheticConfig(rows=30))
    report = plan_windows(source, [0, 1, 2], CONFIG).report
    assert report.samples == 90
    assert set(report.excluded.values()) == {0}
    assert report.masked_steps == {"episode_end": 3 * (1 + 2 + 3), "state_gap": 0, "unknown": 0}


def test_one_gap_excludes_the_windows_across_it() -> None:
    source = SyntheticSource(SyntheticConfig(rows=30))
    state = flags(source, "valid.state").copy()
    state[10] = False
    source.columns["valid.state"] = state
    windows = plan_windows(source, [0], CONFIG)
    assert windows.report.excluded["no_state"] == 1
    assert windows.report.excluded["history_gap"] == 5
    assert set(range(30)) - set(windows.row.tolist()) == set(range(10, 16))
    assert windows.report.masked_steps["state_gap"] == 3
    assert windows.known[list(windows.row).index(9)].tolist() == [True, False, True, True]


def history_rows(windows: Windows, steps: int) -> NDArray[np.int64]:
    return np.array([windows.history(sample, steps) for sample in range(len(windows))])


def test_the_history_repeats_the_first_row_of_its_own_episode() -> None:
    windows = plan_windows(SyntheticSource(SyntheticConfig(rows=30)), [1], CONFIG)
    rows = history_rows(windows, 6)
    assert rows[0].tolist() == [30] * 6
    assert rows[2].tolist() == [30, 30, 30, 30, 31, 32]
    assert rows[-1].tolist() == [54, 55, 56, 57, 58, 59]


@pytest.mark.parametrize(("column", "reason"), [("valid.camera", "no_image"), ("valid.lidar", "no_cloud")])
def test_a_missing_modality_is_counted_or_allowed(column: str, reason: str) -> None:
    source = SyntheticSource(SyntheticConfig(rows=30))
    source.columns[column] = np.arange(len(source)) % 3 != 0
    strict = plan_windows(source, [0, 1, 2], CONFIG)
    assert (strict.report.samples, strict.report.excluded[reason]) == (60, 30)
    blank = DataConfig(history_steps=6, horizon_steps=4, missing_modality=MissingModality.blank)
    assert plan_windows(source, [0, 1, 2], blank).report.samples == 90


def test_a_data_set_without_a_modality_excludes_all_rows() -> None:
    source = SyntheticSource(SyntheticConfig(rows=30))
    del source.columns["valid.lidar"]
    assert plan_windows(source, [0], CONFIG).report.excluded["no_cloud"] == 30


def test_a_longer_horizon_than_the_labels_is_refused() -> None:
    with pytest.raises(TrainError, match="labels 10 steps") as caught:
        plan_windows(SyntheticSource(SyntheticConfig()), [0], DataConfig(horizon_steps=12))
    assert caught.value.cure == "set data.horizon_steps=10 or less"


@pytest.mark.parametrize(
    "values", [{"history_steps": 0}, {"horizon_steps": 0}, {"robot_width_m": 0.0}, {"cache_mib": -1}]
)
def test_impossible_settings_are_refused(values: dict[str, float]) -> None:
    with pytest.raises(SettingError, match=next(iter(values))):
        DataConfig(**values)  # type: ignore[arg-type]  # the point of the test
