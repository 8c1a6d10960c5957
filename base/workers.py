"""Who does the work: this process, or several beside it."""

import os
import signal
import threading
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from types import TracebackType
from typing import Any, Protocol, runtime_checkable

import cv2

from navtool.base.errors import OutputError
from navtool.base.meter import Meter, OnAdvance

_SHARED_EACH_S = 0.05
"""Between two times at which a process says how far it is and asks whether it is still wanted."""
_POLL_S = 0.2


class Stopped(Exception):  # noqa: N818 - not an error: the ingest was asked to end
    """The work is no longer wanted."""


@runtime_checkable
class Workers(Protocol):
    """Runs steps: functions whose last argument is a `Meter`."""

    def __enter__(self) -> "Workers":
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End; what has not begun is not done, and what has begun ends soon."""

    def submit[T](self, work: int, step: Callable[..., T], *arguments: Any) -> Future[T]:
        """Have a step of so many units of work done."""

    def wait(self, futures: Collection[Future[Any]]) -> None:
        """Return when one of these is done, or after a short while; whatever ended before is reported then."""


def make_workers(count: int, on_advance: OnAdvance) -> Workers:
    """This process alone, or so many beside it; this one reports how far the steps are."""
    return _Here(on_advance) if count == 1 else _Processes(count, on_advance)


def outcome[T](future: Future[T]) -> T:
    """The result of work that is done, or its error.

    Raises:
        OutputError: The process that did it is gone.
    """
    try:
        return future.result()
    except BrokenProcessPool as error:
        raise _broken() from error


def _broken() -> OutputError:
    return OutputError(
        "a worker process was ended from outside, perhaps for want of memory",
        cure="run the command again, with fewer --workers; what was reported as done is done",
    )


class _Here:
    """Every step is done at once, in this process."""

    def __init__(self, on_advance: OnAdvance) -> None:
        self._on_advance = on_advance

    def __enter__(self) -> "_Here":
        cv2.setNumThreads(1)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    def submit[T](self, work: int, step: Callable[..., T], *arguments: Any) -> Future[T]:
        future: Future[T] = Future()
        try:
            with Meter(work, self._on_advance) as meter:
                result = step(*arguments, meter)
            future.set_result(result)
        except Exception as error:
            future.set_exception(error)
        return future

    def wait(self, futures: Collection[Future[Any]]) -> None:
        if futures:
            raise ValueError("work that was done at once cannot be waited for")


class _Processes:
    """Processes that leave interrupts to this one, end with it, and count together what they do."""

    def __init__(self, count: int, on_advance: OnAdvance) -> None:
        context = get_context("spawn")
        self._on_advance = on_advance
        self._counts = context.Array("Q", 2)
        self._stop = context.Event()
        self._reported = (0, 0)
        self._pool = ProcessPoolExecutor(count, context, initializer=_begin, initargs=(self._counts, self._stop))

    def __enter__(self) -> "_Processes":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._pool.shutdown(cancel_futures=True)

    def submit[T](self, work: int, step: Callable[..., T], *arguments: Any) -> Future[T]:
        try:
            # A process that this begins is deaf to interrupts from its first moment on, not only once it has imported.
            with _interrupts_held():
                return self._pool.submit(_call, work, step, *arguments)
        except BrokenProcessPool as error:
            raise _broken() from error

    def wait(self, futures: Collection[Future[Any]]) -> None:
        wait(futures, _POLL_S, FIRST_COMPLETED)
        with self._counts.get_lock():
            done, spared = self._counts[:]
        self._on_advance(done - self._reported[0], spared - self._reported[1])
        self._reported = done, spared


@contextmanager
def _interrupts_held() -> Iterator[None]:
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)


class _Counted:
    """What a worker process knows of its parent, and has not reported to it yet."""

    counts: Any = None
    stop: Any = None
    done: int = 0
    spared: int = 0
    due_s: float = 0.0


def _begin(counts: Any, stop: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    _Counted.counts, _Counted.stop = counts, stop
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _call[T](work: int, step: Callable[..., T], *arguments: Any) -> T:
    try:
        with Meter(work, _count) as meter:
            return step(*arguments, meter)
    finally:
        # Before its result is there: who has all results knows of all work.
        _share()


def _count(done: int, spared: int) -> None:
    _Counted.done += done
    _Counted.spared += spared
    if time.monotonic() < _Counted.due_s:
        return
    _Counted.due_s = time.monotonic() + _SHARED_EACH_S
    _share()
    if _Counted.stop.is_set():
        raise Stopped


def _share() -> None:
    with _Counted.counts.get_lock():
        _Counted.counts[0] += _Counted.done
        _Counted.counts[1] += _Counted.spared
    _Counted.done = _Counted.spared = 0
