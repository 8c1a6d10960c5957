"""Who wants to know how far a long command is."""

from typing import Protocol, runtime_checkable


@runtime_checkable
class Progress(Protocol):
    """Learns how far a command is; the command line draws it.

    Guarantee: as long as nothing ends the command, the work reported as done or not to be done adds up to what it
    began with, and never to more.
    """

    def begin(self, things: int, work: int) -> None:
        """So many things are to be done (recordings, checks), of so many units of work that each take about as long."""

    def advance(self, done: int, spared: int) -> None:
        """So many units of work were done, and so many will not be done after all."""

    def done(self, things: int, name: str) -> None:
        """So many things are done, this one last."""


class Silent:
    """Wants to know nothing."""

    def begin(self, things: int, work: int) -> None:
        """Ignore it."""

    def advance(self, done: int, spared: int) -> None:
        """Ignore it."""

    def done(self, things: int, name: str) -> None:
        """Ignore it."""
