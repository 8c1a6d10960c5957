"""Which time counts: header stamps where they can be used, record time where not, and always said why."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from navtool.datasets.ingest.clock import NO_STAMP, clock_offset, stream_time

RECORD = np.arange(10, dtype=np.int64) * 100_000_000 + 1_700_000_000_000_000_000
LATE = 25_000_000


def test_header_stamps_are_used_where_they_are() -> None:
    time = stream_time(RECORD - LATE, RECORD, -LATE)
    assert time.source == "header"
    np.testing.assert_array_equal(time.stamps_ns, RECORD - LATE)
    assert time.offset_ns == -LATE


def test_a_type_without_header_takes_record_time() -> None:
    time = stream_time(np.full(10, NO_STAMP), RECORD, -LATE)
    assert time.source == "record"
    np.testing.assert_array_equal(time.stamps_ns, RECORD)
    assert "no header" in time.notes[0]


def test_headerless_streams_follow_a_simulated_clock() -> None:
    simulated = RECORD - RECORD[0] + 10_000_000_000
    reference = clock_offset(simulated, RECORD)
    time = stream_time(np.full(10, NO_STAMP), RECORD, reference)
    np.testing.assert_array_equal(time.stamps_ns, simulated)
    assert "moved by" in time.notes[0]


def test_empty_headers_take_record_time_and_single_ones_are_counted() -> None:
    assert stream_time(np.zeros(10, dtype=np.int64), RECORD, None).source == "record"
    some = RECORD.copy()
    some[3] = 0
    time = stream_time(some, RECORD, 0)
    assert time.source == "header"
    assert time.unstamped == 1
    assert 3 not in time.order


def test_a_clock_that_was_never_set_is_not_believed() -> None:
    time = stream_time(RECORD - RECORD[0] + 1, RECORD, -LATE)
    assert time.source == "record"
    assert "away from that of the grid's stream" in time.notes[0]


@given(st.lists(st.integers(1, 50), min_size=1, max_size=40))
def test_stamps_strictly_increase_and_nothing_vanishes_uncounted(offsets: list[int]) -> None:
    header = RECORD[0] + np.array(offsets, dtype=np.int64) * 1_000_000
    record = RECORD[0] + np.arange(len(offsets), dtype=np.int64)
    time = stream_time(header, record, clock_offset(header, record))
    assert (np.diff(time.stamps_ns) > 0).all()
    np.testing.assert_array_equal(header[time.order], time.stamps_ns)
    assert time.stamps_ns.size + time.repeated == len(offsets)
    assert time.backwards == int((np.diff(header) < 0).sum())
