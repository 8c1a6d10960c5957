"""What a step's meter tells adds up, whatever the step says of itself."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.base.meter import Meter

places = st.lists(st.integers(-10, 200), max_size=20)


@given(
    st.integers(0, 10**12),
    places,
    places,
    st.integers(-5, 100),
    st.integers(-5, 100),
    st.floats(0.0, 1.0),
    st.booleans(),
)
def test_a_step_adds_up_and_never_runs_backwards(
    work: int, first: list[int], second: list[int], begin: int, end: int, share: float, fails: bool
) -> None:
    told: list[tuple[int, int]] = []
    try:
        with Meter(work, lambda done, spared: told.append((done, spared))) as meter:
            one, other = meter.part(begin, end, share), meter.part(0, 100, 1 - share)
            for place in first:
                one(place)
            assert sum(done for done, _ in told) <= work * share + 1e-3
            for place in second:
                other(place)
            if fails:
                raise KeyError
    except KeyError:
        assert sum(done for done, _ in told[:-1]) <= work
    assert min(min(entry) for entry in told) >= 0
    done, spared = (sum(entry[kind] for entry in told) for kind in (0, 1))
    assert done + spared == work
    assert fails or spared == 0


def test_a_part_counts_as_far_as_it_has_come() -> None:
    told: list[int] = []
    with Meter(1000, lambda done, _: told.append(done)) as meter:
        reached = meter.part(50, 150, 0.5)
        for place in (50, 75, 60, 150, 400):
            reached(place)
        assert told == [0, 125, 0, 375, 0]
    assert sum(told) == 1000


def test_a_step_that_turns_out_to_be_needless_counts_what_it_did() -> None:
    told: list[tuple[int, int]] = []
    with Meter(10, lambda done, spared: told.append((done, spared))) as meter:
        meter.part(0, 4, 0.5)(4)
        meter.spare()
    assert told == [(5, 0), (0, 5), (0, 0)]


def test_threads_count_together() -> None:
    told: list[int] = []
    with Meter(40_000, lambda done, _: told.append(done)) as meter:
        threads = [
            threading.Thread(
                target=lambda reached: [reached(n) for n in range(5000)], args=(meter.part(0, 5000, 0.25),)
            )
            for _ in range(4)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert sum(told) == pytest.approx(40_000, abs=4 * 10)
    assert sum(told) == 40_000
