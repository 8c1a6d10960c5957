"""Who does the work: this process, or several beside it."""

import os
import signal
import threading
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from types import TracebackType
from typing import Any, Protocol, runtime_checkable

import cv2

from navtool.datasets.errors import OutputError

type Advance = Callable[[int], None]
"""Called with the number of bytes read, 0 by work that reads none; raises where the work is no longer wanted."""

_TELL_EVERY = 1 << 20
_POLL_S = 0.2


class Stopped(Exception):  # noqa: N818 - not an error: the ingest was asked to end
    """The work is no longer wanted."""


@runtime_checkable
class Workers(Protocol):
    """Runs functions whose last argument is an `Advance`."""

    def __enter__(self) -> "Workers":
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End; what has not begun is not done, and what has begun ends soon."""

    def submit[T](self, function: Callable[..., T], *arguments: Any) -> Future[T]:
        """Have the function called."""

    def wait(self, futures: Collection[Future[Any]]) -> None:
        """Return when one of these is done, or after a short while."""


def make_workers(count: int, advance: Advance) -> Workers:
    """This process alone, or so many beside it."""
    return _Here(advance) if count == 1 else _Processes(count, advance)


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
    """Every function is called at once, in this process."""

    def __init__(self, advance: Advance) -> None:
        self._advance = advance

    def __enter__(self) -> "_Here":
        cv2.setNumThreads(1)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        return None

    def submit[T](self, function: Callable[..., T], *arguments: Any) -> Future[T]:
        future: Future[T] = Future()
        try:
            future.set_result(function(*arguments, self._advance))
        except Exception as error:
            future.set_exception(error)
        return future

    def wait(self, futures: Collection[Future[Any]]) -> None:
        if futures:
            raise ValueError("work that was done at once cannot be waited for")


class _Processes:
    """Processes that leave interrupts to this one, end with it, and count together what they read."""

    def __init__(self, count: int, advance: Advance) -> None:
        context = get_context("spawn")
        self._advance = advance
        self._read = context.Value("Q", 0)
        self._stop = context.Event()
        self._told = 0
        self._pool = ProcessPoolExecutor(count, context, initializer=_begin, initargs=(self._read, self._stop))

    def __enter__(self) -> "_Processes":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._stop.set()
        self._pool.shutdown(cancel_futures=True)

    def submit[T](self, function: Callable[..., T], *arguments: Any) -> Future[T]:
        try:
            # A process that this begins is deaf to interrupts from its first moment on, not only once it has imported.
            with _interrupts_held():
                return self._pool.submit(_call, function, *arguments)
        except BrokenProcessPool as error:
            raise _broken() from error

    def wait(self, futures: Collection[Future[Any]]) -> None:
        wait(futures, _POLL_S, FIRST_COMPLETED)
        read = int(self._read.value)
        self._advance(read - self._told)
        self._told = read


@contextmanager
def _interrupts_held() -> Iterator[None]:
    held = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)


class _Telling:
    """What a worker process knows of its parent."""

    read: Any = None
    stop: Any = None
    untold: int = 0


def _begin(read: Any, stop: Any) -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    cv2.setNumThreads(1)
    _Telling.read, _Telling.stop = read, stop
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _call[T](function: Callable[..., T], *arguments: Any) -> T:
    return function(*arguments, _advance)


def _advance(read_bytes: int) -> None:
    _Telling.untold += read_bytes
    if read_bytes and _Telling.untold < _TELL_EVERY:
        return
    with _Telling.read.get_lock():
        _Telling.read.value += _Telling.untold
    _Telling.untold = 0
    if _Telling.stop.is_set():
        raise Stopped
