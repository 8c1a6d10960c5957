"""What the progress bar draws, by a clock of the test."""

import pytest

from navtool.cli.progress import WorkProgress


class Clock:
    now_s = 1000.0

    def __call__(self) -> float:
        return self.now_s


@pytest.mark.parametrize("spared", [0, 300])
def test_an_even_pace_foretells_the_end_whatever_is_spared(spared: int) -> None:
    clock = Clock()
    bar = WorkProgress("recordings", clock)
    bar.begin(10, 1000 + spared)
    clock.now_s += 20.0
    assert bar.left_s is None, "starting the workers is no work"
    bar.advance(0, spared)
    for second in range(101):
        bar.advance(10 if second else 0, 0)
        if second == 0:
            bar.advance(1, 0)
        if second >= 2:
            assert bar.left_s == pytest.approx(100 - second, rel=0.1, abs=1.0)
            assert bar.share == pytest.approx(second / 100, abs=0.02)
        clock.now_s += 1.0


def test_the_bar_ends_at_its_end_however_little_time_there_was() -> None:
    clock = Clock()
    bar = WorkProgress("recordings", clock)
    bar.begin(2, 1000)
    for _ in range(700):
        bar.advance(1, 0)
    bar.done(1, "a")
    assert bar.share == pytest.approx(0.7)
    bar.advance(0, 300)
    bar.done(2, "b")
    assert bar.share == 1.0


def test_the_steps_of_another_pace_do_not_make_the_end_jump() -> None:
    """Ten recordings of a quick eighth and a slow rest: the foretold end stays within a quarter after the first."""
    clock = Clock()
    bar = WorkProgress("recordings", clock)
    bar.begin(10, 1000)
    bar.advance(1, 0)
    began_s, ends_s = clock.now_s, []
    for number in range(10):
        for work, pace_s in ((12, 0.02), (88, 0.12)):
            for _ in range(work):
                clock.now_s += pace_s
                bar.advance(1, 0)
                if number and bar.left_s is not None:
                    ends_s.append(clock.now_s - began_s + bar.left_s)
    took_s = clock.now_s - began_s
    assert min(ends_s) > 0.75 * took_s
    assert max(ends_s) < 1.25 * took_s


def test_work_of_minutes_is_told_once_where_nobody_looks(capfd: pytest.CaptureFixture[str]) -> None:
    clock = Clock()
    with WorkProgress("epochs", clock) as bar:
        bar.begin(30, 3000)
        for _ in range(5):
            bar.advance(10, 0)
            clock.now_s += 6.0
        bar.done(1, "loss 1")
    assert capfd.readouterr() == ("", "1 of 30 epochs: about 30 minutes to go\n")


def test_nothing_is_drawn_where_nobody_looks(capfd: pytest.CaptureFixture[str]) -> None:
    with WorkProgress("recordings") as bar:
        bar.begin(1, 10)
        bar.advance(10, 0)
        bar.done(1, "a")
    assert bar.share == 1.0
    assert capfd.readouterr() == ("", "")
