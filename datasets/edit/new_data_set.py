"""A new data set in a folder, episode by episode, that is there whole or not at all."""

import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from navtool.base.errors import DatasetsError, OccupiedError
from navtool.base.progress import Progress, Silent
from navtool.datasets.store.reading import REBUILD
from navtool.datasets.store.writer import data_set_folder


@dataclass(frozen=True, slots=True)
class EditReport:
    """A data set that was made."""

    dataset: str
    episodes: int
    rows: int


@contextmanager
def new_folder(out: Path) -> Iterator[Path]:
    """A folder to write into, which becomes ``out`` as a whole when it is left without an error.

    Raises:
        OccupiedError: Something is there already.
        DatasetsError: Another process writes the same.
        OutputError: It cannot be written.
    """
    refuse_there(out)
    with data_set_folder(out).staged() as staging:
        yield staging


def refuse_there(out: Path) -> None:
    """Do nothing where a new data set may be made.

    Raises:
        OccupiedError: Something is there already.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise OccupiedError("is there already", where=out, cure="name a new folder with --out")


def copy_file(source: Path, target: Path) -> None:
    """Copy a file of a data set.

    Raises:
        DatasetsError: It is not there.
    """
    if not source.is_file():
        raise DatasetsError("is not there", where=source, cure=REBUILD)
    shutil.copyfile(source, target)


def copy_folder(source: Path, target: Path) -> None:
    """Copy a folder of a data set with all within.

    Raises:
        DatasetsError: It is not there.
    """
    if not source.is_dir():
        raise DatasetsError("is not there", where=source, cure=REBUILD)
    shutil.copytree(source, target, copy_function=shutil.copyfile)


def counted(progress: Progress | None, episodes: int) -> Callable[[str], None]:
    """A function to call with the name of each episode that is done."""
    shown, done = progress or Silent(), 0
    shown.begin(episodes, episodes)

    def count(name: str) -> None:
        nonlocal done
        done += 1
        shown.advance(1, 0)
        shown.done(done, name)

    return count
