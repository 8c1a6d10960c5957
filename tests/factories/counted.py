"""A progress that keeps what it learns."""


class Counted:
    """Counts what is reported to it."""

    def __init__(self) -> None:
        self.begun: tuple[int, int] | None = None
        """Things and units of work that were begun with."""
        self.worked, self.spared = 0, 0
        self.finished: list[tuple[int, str]] = []

    def begin(self, things: int, work: int) -> None:
        """Keep it."""
        assert self.begun is None
        self.begun = (things, work)

    def advance(self, done: int, spared: int) -> None:
        """Count it."""
        self.worked += done
        self.spared += spared

    def done(self, things: int, name: str) -> None:
        """Keep it."""
        self.finished.append((things, name))

    def adds_up(self) -> bool:
        """Whether everything that was begun is done or spared, and all things are finished."""
        assert self.begun is not None
        return self.begun == (self.finished[-1][0], self.worked + self.spared)
