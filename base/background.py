"""One thread beside the one that reads: it encodes and compresses, which needs no interpreter."""

from collections import deque
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from types import TracebackType

_AHEAD = 24
"""Pieces of work that may wait; with clouds of 100,000 points some 50 MB."""


class Background:
    """Calls functions one after the other, in the order in which they were handed over.

    Leaving it without an error waits for all of them; the first error that one of them raised is raised then, or when
    the next one is handed over. None is called behind one that failed: a writer that failed may not be used again.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(1)
        self._waiting: deque[Future[None]] = deque()
        self._failed = False

    def call[**P](self, function: Callable[P, object], *arguments: P.args, **options: P.kwargs) -> None:
        """Have a function called; waits where too much is waiting already."""
        self._waiting.append(self._thread.submit(self._run, partial(function, *arguments, **options)))
        while len(self._waiting) > _AHEAD or (self._waiting and self._waiting[0].done()):
            self._waiting.popleft().result()

    def _run(self, function: Callable[[], object]) -> None:
        if self._failed:
            return
        try:
            function()
        except BaseException:
            self._failed = True
            raise

    def __enter__(self) -> "Background":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        try:
            while self._waiting:
                if kind is None:
                    self._waiting.popleft().result()
                else:
                    self._waiting.popleft().cancel()
        finally:
            self._thread.shutdown(cancel_futures=True)
