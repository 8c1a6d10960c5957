"""How much of one step's work is done, counted so that it always adds up."""

import threading
from collections.abc import Callable
from types import TracebackType

type OnAdvance = Callable[[int, int], None]
"""Called with units of work that were done and units that will not be done; raises where no more work is wanted."""


class Meter:
    """Counts the work of one step, from any of its threads.

    Guarantees: what is reported never runs backwards, and of a step that has ended it adds up to the step's work: the
    rest counts as done where the step succeeded, as not to be done where it failed.
    """

    def __init__(self, work: int, on_advance: OnAdvance) -> None:
        """Count for a step.

        Args:
            work: Units of the whole step.
            on_advance: Called from one thread at a time.
        """
        self._work, self._left, self._on_advance = work, work, on_advance
        self._lock = threading.Lock()

    def part(self, first: int, last: int, share: float = 1.0) -> Callable[[int], None]:
        """What to call with how far a part of the step is, on a scale of its own such as bytes or record times.

        Args:
            first: Where the part begins on its scale.
            last: Where it ends; a position outside counts as the nearer end, one before an earlier one as that one.
            share: Of the step's work, 0 to 1.
        """
        work, counted = self._work * share, 0

        def on_reached(position: int) -> None:
            nonlocal counted
            with self._lock:
                passed = min(max((position - first) / (last - first), 0.0), 1.0) if last > first else 1.0
                done = min(max(int(work * passed) - counted, 0), self._left)
                counted += done
                self._left -= done
                self._on_advance(done, 0)

        return on_reached

    def spare(self) -> None:
        """The rest of the step's work is not to be done."""
        with self._lock:
            spared, self._left = self._left, 0
            self._on_advance(0, spared)

    def __enter__(self) -> "Meter":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            self.spare()
            return
        with self._lock:
            done, self._left = self._left, 0
            self._on_advance(done, 0)
