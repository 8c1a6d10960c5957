"""Runs of true, joined over short gaps."""

from itertools import pairwise

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from navtool.sim.drive.stretches import stretches


@given(st.lists(st.booleans(), max_size=60), st.integers(0, 6))
def test_runs_cover_what_is_true_and_gaps_shorter_than_the_limit(flags: list[bool], gap: int) -> None:
    covered = np.zeros(len(flags), bool)
    found = stretches(np.array(flags, bool), float(gap))
    for start, end in found:
        assert flags[start]
        assert flags[end - 1]
        covered[start:end] = True
    naive = list(flags)
    for first in range(len(flags)):
        for length in range(1, gap):
            inside = flags[first : first + length]
            between = first > 0 and first + length < len(flags)
            if between and not any(inside) and flags[first - 1] and flags[first + length]:
                naive[first : first + length] = [True] * length
    assert covered.tolist() == naive
    assert all(b[0] - a[1] >= max(gap, 1) for a, b in pairwise(found))
