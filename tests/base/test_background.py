"""The thread beside."""

import threading

import pytest

from navtool.base.background import Background


def test_calls_come_in_their_order_and_are_waited_for() -> None:
    called: list[int] = []
    with Background() as beside:
        for number in range(100):
            beside.call(called.append, number)
    assert called == list(range(100))


def test_nothing_is_called_behind_a_call_that_failed() -> None:
    called: list[int] = []
    may_fail = threading.Event()

    def fail() -> None:
        may_fail.wait(10)
        raise OSError("no space left")

    def hand_over() -> None:
        with Background() as beside:
            beside.call(called.append, 0)
            beside.call(fail)
            for number in range(1, 10):
                beside.call(called.append, number)
            may_fail.set()

    with pytest.raises(OSError, match="no space left"):
        hand_over()
    assert called == [0]
