"""What a user should look at."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Note:
    """A line for the user, with no bearing on the exit code. Files and screens show its text alone."""

    code: str
    """What it is about, such as ``clock.late``, whatever its words; docs/notes.md lists them."""
    text: str
    """The line."""

    def __str__(self) -> str:
        """The line."""
        return self.text

    def about(self, subject: str) -> "Note":
        """The same of a stream or a recording, which it then begins with."""
        return Note(self.code, f"{subject}: {self.text}")
