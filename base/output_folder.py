"""The folder of a run's maps, or of what was fitted: there whole, or not at all."""

import fcntl
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import fields
from pathlib import Path

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.files import read_json
from navtool.base.from_plain import from_plain
from navtool.base.report import fields_of

LINEAGE = "lineage.json"
"""Name of the file that says what the output was made from, and what the run told."""
_OF_THE_MOMENT = ("out", "seconds", "done_before")
_CURE = "name another folder with --out, or remove this one"


def refuse_other_output(out: Path, kind: str) -> None:
    """Do nothing where outputs of a kind are or may be made.

    Raises:
        DatasetsError: It is a file, or a folder that holds something else.
    """
    if out.exists() and not out.is_dir():
        raise DatasetsError("is a file", where=out, cure="name a folder with --out")
    if out.is_dir() and any(out.iterdir()) and not _is_ours(out, kind):
        raise DatasetsError("the folder holds something else", where=out, cure="name an empty or a new folder")


def finished[T](out: Path, identity: Mapping[str, object], report: type[T]) -> T | None:
    """What the run told whose output lies here, made from the same; None where there is none.

    Args:
        out: The folder.
        identity: What has to be equal.
        report: The dataclass of what is told.

    Raises:
        DatasetsError: What is here was made from something else; what differs is named.
    """
    if not (out / LINEAGE).is_file():
        return None
    found = read_json(out / LINEAGE, _CURE)
    made = found.get("made_from")
    before = made if isinstance(made, dict) else {}
    if differ := [key for key, value in identity.items() if before.get(key) != value]:
        what = f"what is here was made with another {', '.join(key.replace('_', ' ') for key in differ)}"
        raise DatasetsError(what, where=out, cure=_CURE)
    told = found.get("report")
    told = {**told, "out": out.as_posix()} if isinstance(told, dict) else {}
    names = {entry.name for entry in fields(report)}  # type: ignore[arg-type]
    known = {key: value for key, value in told.items() if key in names}
    return from_plain(report, known, where=out / LINEAGE)


def report_content(report: object) -> dict[str, object]:
    """A report as its lineage holds it: without what differs between equal runs."""
    return {key: value for key, value in fields_of(report).items() if key not in _OF_THE_MOMENT}


@contextmanager
def staged_output(out: Path) -> Iterator[Path]:
    """A folder beside the output that takes its place, as a whole, when it is left without an error.

    What an interrupted run left is removed first, and what this one leaves if it fails.

    Raises:
        DatasetsError: Another process writes the same output.
        OutputError: It cannot be written.
    """
    staging = out.absolute().parent / f".{out.absolute().name}.unfinished"
    lock_path = staging.with_suffix(".lock")
    cure = "check the disk's space and the folder's rights"
    try:
        staging.parent.mkdir(parents=True, exist_ok=True)
        lock = lock_path.open("w")
    except OSError as error:
        raise OutputError(f"cannot be written ({error.strerror})", where=out, cure=cure) from error
    with lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            cure = "wait until it is done, or name another folder with --out"
            raise DatasetsError("another process is writing it", where=out, cure=cure) from error
        try:
            shutil.rmtree(staging, ignore_errors=True)
            staging.mkdir()
            yield staging
            if out.is_dir():
                out.rmdir()
            staging.rename(out)
        except OSError as error:
            raise OutputError(f"cannot be written ({error.strerror or error})", where=out, cure=cure) from error
        finally:
            shutil.rmtree(staging, ignore_errors=True)
            lock_path.unlink(missing_ok=True)


def lineage_content(kind: str, identity: Mapping[str, object], about: object) -> dict[str, object]:
    """What the lineage file says of where an output is from.

    Args:
        kind: Of output.
        identity: What has to be equal for the same output.
        about: What else is known of the input or inputs.
    """
    return {"kind": kind, "made_from": dict(identity), "input": about}


def _is_ours(out: Path, kind: str) -> bool:
    try:
        return read_json(out / LINEAGE, _CURE).get("kind") == kind
    except DatasetsError:
        return False
