"""Where the errors of the libraries below become errors of navtool."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from navtool.base.errors import DatasetsError


@contextmanager
def translated(what: str, *, where: str | Path, cure: str | None = None) -> Iterator[None]:
    """Raise every foreign exception of the block as one that names the file, keeping the original as its cause.

    The libraries below answer damaged bytes with their own errors, but also with `AssertionError`, `KeyError`,
    `struct.error`, `MemoryError` and others: hence all of them. An error of navtool's own gets the file it lacks.
    """
    try:
        yield
    except DatasetsError as error:
        if error.where is not None:
            raise
        raise DatasetsError(error.what, where=where, cure=error.cure) from error
    except Exception as error:
        raise DatasetsError(f"{what}: {describe(error)}", where=where, cure=cure) from error


def describe(error: BaseException) -> str:
    """The error in one line, with its class where the message alone says little."""
    text = " ".join(str(error).split()).rstrip(".")
    name = type(error).__name__
    return f"{name}: {text}" if text else name
