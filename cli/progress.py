"""Progress bars, drawn on standard error where a person looks at it."""

import time
from collections.abc import Callable
from datetime import timedelta
from math import ceil
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, Task, TaskID, TextColumn
from rich.text import Text

_DRAW_S = 0.1
_FOREKNOWN_S = 1.0
"""What has gone on for less says nothing of the rest."""
_LONG_S = 60.0
"""Where nothing is drawn, a rest that takes longer is told once."""


class WorkProgress:
    """Draws how far a command is, and how long the rest takes at the pace of what was done so far.

    It goes when it is done; where nobody looks nothing is drawn. One line is left there of work that takes minutes.
    """

    def __init__(self, things: str, clock: Callable[[], float] = time.monotonic) -> None:
        """Prepare it.

        Args:
            things: What is counted, such as ``recordings``.
            clock: Seconds from any moment on.
        """
        self._console = console = Console(stderr=True)
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f}%"),
            _TimeLeft(),
            console=console,
            transient=True,
            get_time=clock,
            disable=not console.is_terminal,
        )
        self._things, self._clock, self._drawn_s = things, clock, 0.0
        self._count, self._total, self._done = 0, 0, 0
        self._task: TaskID | None = None
        self._told = console.is_terminal

    def begin(self, things: int, work: int) -> None:
        """Begin the bar; its clock runs from the first work on that is done."""
        self._count, self._total = things, work
        self._task = self._bar.add_task(self._counted(0), start=False, total=work, before=0)

    def advance(self, done: int, spared: int) -> None:
        """Move the bar, not more often than it is drawn."""
        first = done > 0 == self._done
        self._done += done
        self._total -= spared
        if first or self._clock() - self._drawn_s > _DRAW_S:
            self._draw()

    def done(self, things: int, name: str) -> None:
        """Say which was finished last."""
        self._draw(f"{self._counted(things)}, last {name}")

    def _counted(self, done: int) -> str:
        """Which one is being done, of how many."""
        return f"{min(done + 1, self._count)} of {self._count} {self._things}"

    @property
    def left_s(self) -> float | None:
        """How long the rest will take; None while that is not known."""
        return None if self._task is None else _left_s(self._bar.tasks[0])

    @property
    def share(self) -> float:
        """Share of the work that is drawn as done."""
        return 0.0 if self._task is None else self._bar.tasks[0].percentage / 100

    def _draw(self, text: str | None = None) -> None:
        if self._task is None:
            return
        if self._done and not self._bar.tasks[0].started:
            self._bar.start_task(self._task)
            self._bar.update(self._task, before=self._done)
        self._bar.update(self._task, description=text, completed=self._done, total=self._total)
        self._drawn_s = self._clock()
        if not self._told and (left_s := self.left_s) is not None:
            self._told = True
            if left_s > _LONG_S:
                self._console.print(f"{self._bar.tasks[0].description}: about {left_s / 60:.0f} minutes to go")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()


class _TimeLeft(ProgressColumn):
    """The time that the rest takes at the mean pace so far: that of the last seconds is another in each step."""

    max_refresh = 0.5

    def render(self, task: Task) -> Text:
        left_s = _left_s(task)
        return Text("-:--:--" if left_s is None else str(timedelta(seconds=ceil(left_s))), style="progress.remaining")


def _left_s(task: Task) -> float | None:
    done = task.completed - task.fields["before"]  # since the clock runs: it begins at the end of the first work
    if task.elapsed is None or task.elapsed < _FOREKNOWN_S or done <= 0 or task.remaining is None:
        return None
    return float(task.elapsed * task.remaining / done)
