"""Intervals become labels of rows: later ones win, and none is lost between two rows."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from navtool.datasets.labels.intervals import LabelInterval, covered_rows, label_rows, runs

PERIOD = 100
STAMPS = np.arange(20, dtype=np.int64) * PERIOD

INTERVALS = st.tuples(st.integers(-300, 2300), st.integers(0, 1500), st.integers(0, 1), st.sampled_from("abc")).map(
    lambda drawn: LabelInterval(drawn[0], drawn[0] + drawn[1], drawn[2], drawn[3], 0.5)
)


@given(start=st.integers(-300, 2300), length=st.integers(0, 1500))
def test_the_rows_inside_are_covered_and_a_short_event_covers_its_nearest_row(start: int, length: int) -> None:
    rows = np.arange(20)[covered_rows(STAMPS, PERIOD, start, start + length)]
    inside = np.flatnonzero((start <= STAMPS) & (start + length > STAMPS))
    if inside.size:
        np.testing.assert_array_equal(rows, inside)
    else:
        middle = (2 * start + length) // 2
        distance = np.abs(STAMPS - middle)
        assert rows.size == int(distance.min() <= PERIOD / 2)
        assert (distance[rows] == distance.min()).all()


@given(intervals=st.lists(INTERVALS, max_size=6))
def test_the_last_interval_that_covers_a_row_wins(intervals: list[LabelInterval]) -> None:
    outcome, reason, confidence = label_rows(STAMPS, PERIOD, intervals, 0.9)
    for row in range(20):
        covering = [
            interval
            for interval in intervals
            if row in np.arange(20)[covered_rows(STAMPS, PERIOD, interval.start_ns, interval.end_ns)]
        ]
        expected = (covering[-1].outcome, covering[-1].reason, 0.5) if covering else (1, "", 0.9)
        assert (outcome[row], reason[row]) == expected[:2]
        assert confidence[row] == np.float32(expected[2])


def test_adjacent_intervals_share_no_row() -> None:
    first, second = covered_rows(STAMPS, PERIOD, 0, 500), covered_rows(STAMPS, PERIOD, 500, 900)
    assert (first, second) == (slice(0, 5), slice(5, 9))


@given(flags=st.lists(st.booleans(), max_size=30))
def test_runs_rebuild_the_flags(flags: list[bool]) -> None:
    rebuilt = np.zeros(len(flags), dtype=np.bool_)
    found = runs(np.array(flags, dtype=np.bool_))
    for first, stop in found:
        assert first < stop
        rebuilt[first:stop] = True
    assert rebuilt.tolist() == flags
    assert all(left[1] < right[0] for left, right in pairwise(found))
