"""The folder of a command's output: never another's, written by one process at a time, known by what it was made from.

Two ways to write into it: ``staged`` makes an output whole or not at all; an output that grows, piece by piece and run
by run, is ``held`` meanwhile.
"""

import shutil
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import IO

from navtool.base.errors import DatasetsError, OccupiedError, OutputError
from navtool.base.file_lock import take_lock
from navtool.base.files import read_json, write_json
from navtool.base.from_plain import from_plain
from navtool.base.plain import Dataclass, flatten, plain_fields
from navtool.base.setting_error import SettingError

LINEAGE = "lineage.json"
"""Usual name of the file that says what an output was made from, and what was reported of it."""
_OF_THE_MOMENT = ("out", "seconds", "done_before")
"""Fields of a report that differ between equal runs."""
_OTHER = "name another folder with --out, or remove this one"
_RIGHTS = "check the disk's space and the folder's rights"
_SHOWN = 4
"""At most so many differences are named."""
_SHORT = 32
"""Characters of a value that is shown; a hash is longer, and says nothing to a person."""


@dataclass(frozen=True, slots=True)
class OutputFolder:
    """The folder in which a command leaves what it makes."""

    root: Path
    kind: str | None = None
    """What the output's record calls it; None where a record of this name is nobody else's."""
    identity: Mapping[str, object] = field(default_factory=dict)
    """What has to be equal for the same output: hashes, and ``settings`` by their keys; plain values."""
    record: str = LINEAGE
    """Name of the file or folder by which the output is known."""
    lock: str = ".lock"
    """Name of the lock file in an output that grows; one that is made whole has it beside it."""

    def refuse_other(self) -> None:
        """Do nothing where the output is or may be made.

        Raises:
            OccupiedError: It is a file, or a folder that holds something else.
        """
        if self.root.exists() and not self.root.is_dir():
            raise OccupiedError("is a file", where=self.root, cure="name a folder")
        if not self.root.is_dir() or self._is_ours():
            return
        strangers = sorted(path.name for path in self.root.iterdir() if path.name != self.lock)
        if strangers:
            what = f"the folder holds something else ({', '.join(strangers[:3])})"
            raise OccupiedError(what, where=self.root, cure="name an empty or a new folder")

    def refuse_differing(self, before: Mapping[str, object]) -> None:
        """Do nothing where an output of this identity has the one of this folder.

        Args:
            before: The identity of what is in the folder.

        Raises:
            OccupiedError: It was made from something else; what differs is named.
        """
        now, then = flatten(self.identity), flatten(before)
        differ = [key for key in {**now, **then} if then.get(key) != now.get(key)]
        if differ:
            named = ", ".join(_difference(key, then.get(key), now.get(key)) for key in differ[:_SHOWN])
            more = f" and {len(differ) - _SHOWN} more" if len(differ) > _SHOWN else ""
            raise OccupiedError(f"what is here was made with another {named}{more}", where=self.root, cure=_OTHER)

    def finished[T: Dataclass](self, report: type[T]) -> T | None:
        """What was reported of the finished output that lies here; None where there is none.

        Args:
            report: The dataclass of it. What it does not know is left out; its ``out`` is this folder.

        Raises:
            OccupiedError: What is here was made from something else; what differs is named.
            DatasetsError: Its record is damaged.
        """
        file = self.root / self.record
        if not file.is_file():
            return None
        found = read_json(file, _OTHER)
        made = found.get("made_from")
        self.refuse_differing(made if isinstance(made, dict) else {})
        stored = found.get("report")
        stored = {**stored, "out": self.root.as_posix()} if isinstance(stored, dict) else {}
        names = {entry.name for entry in fields(report)}
        try:
            return from_plain(report, {key: value for key, value in stored.items() if key in names}, where=file)
        except SettingError as error:
            raise DatasetsError(f"is damaged ({error.what})", where=file, cure=_OTHER) from error

    @contextmanager
    def staged(self, *, replace: bool = False) -> Iterator[Path]:
        """A folder beside the output that takes its place, as a whole, when it is left without an error.

        What an interrupted run left is removed first, and what this one leaves if it fails.

        Args:
            replace: Whether an output that is there goes when the new one comes.

        Raises:
            DatasetsError: Another process writes the same output.
            OutputError: It cannot be written.
        """
        whole = self.root.absolute()
        staging = whole.with_name(f".{whole.name}.unfinished")
        lock_path = whole.with_name(f".{whole.name}.lock")
        with self._locked(lock_path):
            try:
                _clear(staging, whole)
                staging.mkdir()
                yield staging
                _swap(staging, whole, replace=replace)
            except OSError as error:
                what = f"cannot be written ({error.strerror or error})"
                raise OutputError(what, where=self.root, cure=_RIGHTS) from error
            finally:
                shutil.rmtree(staging, ignore_errors=True)
                lock_path.unlink(missing_ok=True)

    @contextmanager
    def held(self, in_vain: Callable[[], bool]) -> Iterator[None]:
        """Hold the folder, made where it is not there, to go on with the output in it.

        Args:
            in_vain: Whether nothing in the folder is worth keeping; asked at the end where the folder is new.

        Raises:
            DatasetsError: Another process writes to it, or it holds something else.
            OutputError: It cannot be written.
        """
        self.refuse_other()
        created = not self.root.exists()
        with self._locked(self.root / self.lock):
            try:
                yield
            finally:
                if created and in_vain():
                    shutil.rmtree(self.root)

    def write_record(self, staging: Path, about: object, report: Dataclass) -> None:
        """Write what the output was made from; the last file of a staged output.

        Args:
            staging: The folder that becomes the output.
            about: What else is known of the input or inputs: plain values.
            report: A dataclass; what differs between equal runs is left out.

        Raises:
            OutputError: It cannot be written.
        """
        reported = {key: value for key, value in plain_fields(report).items() if key not in _OF_THE_MOMENT}
        content = {"kind": self.kind, "made_from": dict(self.identity), "input": about, "report": reported}
        write_json(staging / self.record, content)

    def _is_ours(self) -> bool:
        record = self.root / self.record
        if self.kind is None:
            return record.exists()
        try:
            return read_json(record, _OTHER).get("kind") == self.kind
        except DatasetsError:
            return False

    def _locked(self, path: Path) -> IO[str]:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            return take_lock(path)
        except BlockingIOError as error:
            cure = "wait until it is done, or name another folder"
            raise DatasetsError("another process is writing to it", where=self.root, cure=cure) from error
        except OSError as error:
            raise OutputError(f"cannot be written ({error.strerror})", where=self.root, cure=_RIGHTS) from error


def _aside(staging: Path) -> Path:
    """Where an output is while another takes its place."""
    return staging.with_suffix(".replaced")


def _clear(staging: Path, whole: Path) -> None:
    """Remove what an interrupted run left unfinished; an output that it had moved aside is there again."""
    shutil.rmtree(staging, ignore_errors=True)
    if _aside(staging).exists() and not whole.exists():
        _aside(staging).replace(whole)
    shutil.rmtree(_aside(staging), ignore_errors=True)


def _swap(staging: Path, whole: Path, *, replace: bool) -> None:
    """Put a finished folder in its place; an older one stands aside until it is there."""
    if replace and whole.exists():
        whole.replace(_aside(staging))
    elif whole.is_dir():
        whole.rmdir()
    try:
        staging.replace(whole)
    except OSError:
        if _aside(staging).exists():
            _aside(staging).replace(whole)
        raise
    shutil.rmtree(_aside(staging), ignore_errors=True)


def _difference(key: str, before: object, now: object) -> str:
    """A key that differs, with its values where a person can read them."""
    key = key.removeprefix("settings.")
    name = key.replace("_", " ") if "." not in key else key
    short = all(len(str(value)) <= _SHORT for value in (before, now))
    return f"{name} (was {before}, now {now})" if short else name
