"""What the operating system says while an episode is written, as an error of the output."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from navtool.base.errors import OutputError


@contextmanager
def output_errors(staged: Path | None) -> Iterator[None]:
    """Turn an `OSError` into an `OutputError`.

    Args:
        staged: The episode's staged folder; None where the output has none.
    """
    try:
        yield
    except OSError as error:
        where = "the output" if staged is None else staged
        cure = "free some space, or choose another disk"
        raise OutputError(f"cannot be written ({error.strerror})", where=where, cure=cure) from error
