"""What a user should look at."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Note:
    """A line for the user, with no bearing on the exit code. Files and screens show its text alone."""

    code: str
    """What it is about, such as ``clock.late``, whatever its words; docs/notes.md lists them. Empty where read back."""
    text: str
    """The line."""

    @classmethod
    def read_back(cls, text: str) -> "Note":
        """One out of a file, which keeps the text alone."""
        return cls("", text)

    def __str__(self) -> str:
        """The line."""
        return self.text

    def about(self, subject: str) -> "Note":
        """The same of a stream or a recording, which it then begins with."""
        return Note(self.code, f"{subject}: {self.text}")
