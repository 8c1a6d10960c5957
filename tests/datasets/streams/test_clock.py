"""Which time counts: header stamps where they can be used, record time where not, and always said why."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from navtool.base.errors import DatasetsError
from navtool.datasets.streams.clock import NO_STAMP, Clock, mend_jumps, reference_clock, stream_time

RECORD = np.arange(10, dtype=np.int64) * 100_000_000 + 1_700_000_000_000_000_000
LATE = 25_000_000
REFERENCE = reference_clock(RECORD - LATE, RECORD)


def test_header_stamps_are_used_where_they_are() -> None:
    time = stream_time(RECORD - LATE, RECORD, REFERENCE)
    assert time.source == "header"
    np.testing.assert_array_equal(time.stamps_ns, RECORD - LATE)
    assert time.offset_ns == -LATE


def test_a_type_without_header_takes_record_time() -> None:
    time = stream_time(np.full(10, NO_STAMP), RECORD, REFERENCE)
    assert time.source == "record"
    np.testing.assert_array_equal(time.stamps_ns, RECORD)
    assert "no header" in time.notes[0].text


@pytest.mark.parametrize("pace", [1.0, 0.8])
def test_headerless_streams_follow_a_simulated_clock_at_its_own_pace(pace: float) -> None:
    simulated = np.rint((RECORD - RECORD[0]) * pace).astype(np.int64) + 10_000_000_000
    between = RECORD[:-1] + 50_000_000
    time = stream_time(np.full(9, NO_STAMP), between, reference_clock(simulated, RECORD))
    np.testing.assert_allclose(time.stamps_ns, simulated[:-1] + round(50_000_000 * pace), atol=1)
    assert "moved onto the clock" in time.notes[0].text
    beyond = stream_time(np.full(1, NO_STAMP), RECORD[-1:] + 7, reference_clock(simulated, RECORD))
    assert beyond.stamps_ns[0] == simulated[-1] + 7


def test_empty_headers_take_record_time_and_single_ones_are_counted() -> None:
    assert stream_time(np.zeros(10, dtype=np.int64), RECORD, None).source == "record"
    some = RECORD.copy()
    some[3] = 0
    time = stream_time(some, RECORD, reference_clock(RECORD, RECORD))
    assert time.source == "header"
    assert time.unstamped == 1
    assert 3 not in time.order


def test_a_clock_that_was_never_set_is_not_believed() -> None:
    time = stream_time(RECORD - RECORD[0] + 1, RECORD, REFERENCE)
    assert time.source == "record"
    assert "away from that of the grid's stream" in time.notes[0].text


@given(st.lists(st.integers(1, 50), min_size=1, max_size=40))
def test_stamps_strictly_increase_and_nothing_vanishes_uncounted(offsets: list[int]) -> None:
    header = RECORD[0] + np.array(offsets, dtype=np.int64) * 1_000_000
    record = RECORD[0] + np.arange(len(offsets), dtype=np.int64)
    time = stream_time(header, record, reference_clock(header, record))
    assert (np.diff(time.stamps_ns) > 0).all()
    np.testing.assert_array_equal(header[time.order], time.stamps_ns)
    assert time.stamps_ns.size + time.repeated == len(offsets)
    assert time.backwards == int((np.diff(header) < 0).sum())


PACED = RECORD[0] + np.arange(200, dtype=np.int64) * 100_000_000
DELAY = np.random.default_rng(0).integers(1_000_000, 8_000_000, PACED.size)


@given(st.integers(20, 180), st.sampled_from([-3600, -7, -1, 1, 7, 3600]))
def test_a_step_of_the_header_clock_is_taken_out_and_told(at: int, seconds: int) -> None:
    header = PACED.copy()
    header[at:] += seconds * 10**9
    mended, jumps = mend_jumps(header, PACED + DELAY, 500_000_000)
    assert [jump.position for jump in jumps] == [at]
    assert abs(jumps[0].by_ns - seconds * 10**9) < 10_000_000
    assert np.abs(mended - PACED).max() < 10_000_000


def test_one_wild_stamp_is_a_step_there_and_back() -> None:
    header = PACED.copy()
    header[50] += 10**12
    mended, jumps = mend_jumps(header, PACED + DELAY, 500_000_000)
    assert [jump.position for jump in jumps] == [50, 51]
    assert np.abs(mended - PACED).max() < 20_000_000


def test_pauses_and_late_records_are_no_steps() -> None:
    paused = PACED.copy()
    paused[100:] += 30 * 10**9
    kept, none = mend_jumps(paused, paused + DELAY, 500_000_000)
    assert none == ()
    np.testing.assert_array_equal(kept, paused)
    record = PACED + DELAY
    record[60:100] = np.maximum(record[60:100], PACED[99])  # four seconds held back, then written at once
    mended, jumps = mend_jumps(PACED, record, 500_000_000)
    assert jumps == ()
    np.testing.assert_array_equal(mended, PACED)


def test_the_clock_can_be_set() -> None:
    header = RECORD - LATE
    assert stream_time(header, RECORD, REFERENCE, Clock.record).source == "record"
    far = RECORD - RECORD[0] + 1
    assert stream_time(far, RECORD, REFERENCE, Clock.header).source == "header"
    with pytest.raises(DatasetsError, match="no message has a header stamp"):
        stream_time(np.zeros(10, dtype=np.int64), RECORD, REFERENCE, Clock.header)
