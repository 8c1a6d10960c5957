"""What writes the results along a recording, one after the other."""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from types import TracebackType
from typing import NamedTuple, Self


@dataclass(frozen=True, slots=True)
class Outcome[R]:
    """A method's result with its place in the row of results."""

    number: int
    """From 0 on, without gaps."""
    stamp_ns: int
    """Stamp of the tick, on the clock of the recording."""
    seconds: float
    """Since the first result."""
    result: R


class Selection(NamedTuple):
    """Which results are taken, by their numbers."""

    every: int = 1
    """1 is all, 10 every tenth."""
    most: int | None = None
    """No more than so many; None for any number."""

    def takes(self, number: int) -> bool:
        """Whether a result is one of them."""
        place, rest = divmod(number, self.every)
        return rest == 0 and (self.most is None or place < self.most)


class Writer[R](ABC):
    """Writes results into a file or a folder of its own.

    It is used as a context manager, in one thread from the first result to the last.

    Attributes:
        name: How reports call what it writes.
        selection: Which results it writes.
        written: How many it has written.
    """

    def __init__(self, name: str, selection: Selection | None = None) -> None:
        self.name, self.selection = name, selection or Selection()
        self.written = 0

    def add(self, outcome: Outcome[R]) -> None:
        """Write the next result, where it is one of those that are wanted."""
        if self.selection.takes(outcome.number):
            self.write(outcome)
            self.written += 1

    @abstractmethod
    def write(self, outcome: Outcome[R]) -> None:
        """Write a result that is wanted."""

    def finish(self) -> None:  # noqa: B027 - most have nothing left
        """Write what is left when the last result is there."""

    def __enter__(self) -> Self:
        return self

    def __exit__(  # noqa: B027 - most hold no file open
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Let go of open files; without an error all was finished before."""


class Writers[R](ExitStack):
    """Several writers as one; leaving it lets go of their files."""

    def __init__(self, writers: Sequence[Writer[R]]) -> None:
        super().__init__()
        self._writers = writers
        for writer in writers:
            self.enter_context(writer)

    def add(self, outcome: Outcome[R]) -> None:
        """Hand the next result to all of them."""
        for writer in self._writers:
            writer.add(outcome)

    def finish(self) -> None:
        """Have all of them write what is left."""
        for writer in self._writers:
            writer.finish()

    def written(self) -> dict[str, int]:
        """How many results each of them holds, by its name."""
        return {writer.name: writer.written for writer in self._writers}
