"""Progress bars, drawn on standard error where a person looks at it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

_TELL_EVERY = 1 << 22


class IngestProgress:
    """Draws how far ingest is."""

    def __init__(self) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f}%"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: TaskID | None = None
        self._recordings = 0
        self._fetching: TaskID | None = None
        self._fetched: dict[str, int] = {}
        self._untold = 0

    def fetched(self, url: str, read_bytes: int) -> None:
        """Say what is being fetched, and how much of it has come."""
        self._fetched[url] = self._fetched.get(url, 0) + read_bytes
        text = f"fetching {url}: {self._fetched[url] / 1e6:.0f} MB"
        if self._fetching is None:
            self._fetching = self._bar.add_task(text, total=None)
        self._bar.update(self._fetching, description=text)

    def begin(self, recordings: int, size_bytes: int) -> None:
        """Begin the bar; every byte passes three times: hashed, planned, read."""
        if self._fetching is not None:
            self._bar.remove_task(self._fetching)
            self._fetching = None
        self._recordings = recordings
        self._task = self._bar.add_task(f"0/{recordings} recordings", total=3 * max(size_bytes, 1))

    def advance(self, read_bytes: int) -> None:
        """Move the bar, not more often than it is drawn."""
        self._untold += read_bytes
        if self._task is not None and self._untold > _TELL_EVERY:
            self._bar.advance(self._task, self._untold)
            self._untold = 0

    def done(self, recordings: int, name: str) -> None:
        """Say which recording was finished last."""
        if self._task is not None:
            self._bar.update(self._task, description=f"{recordings}/{self._recordings} recordings, {name}")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()


class SimulationProgress:
    """Draws how far a simulation is."""

    def __init__(self) -> None:
        self._bar = Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            TextColumn("{task.percentage:3.0f}%"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: TaskID | None = None
        self._episodes = 0

    def begin(self, episodes: int, duration_us: int) -> None:
        """Begin the bar, as long as the drives."""
        self._episodes = episodes
        self._task = self._bar.add_task(f"0/{episodes} episodes", total=max(duration_us, 1))

    def advance(self, microseconds: int) -> None:
        """Move the bar."""
        if self._task is not None and microseconds:
            self._bar.advance(self._task, microseconds)

    def done(self, episodes: int, name: str) -> None:
        """Say which recording was finished last."""
        if self._task is not None:
            self._bar.update(self._task, description=f"{episodes}/{self._episodes} episodes, {name}")

    def __enter__(self) -> Self:
        self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()


@contextmanager
def counted(what: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A bar that is moved by calling it with (done, total)."""
    bar = Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.completed:.0f}/{task.total:.0f}"),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    )
    with bar:
        task = bar.add_task(what, total=total)
        yield lambda done, _: bar.update(task, completed=done)
