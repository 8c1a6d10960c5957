"""Replacing several files of a data set in one step: all of them or none, whenever the process or the machine stops."""

import os
import shutil
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.file_lock import take_lock
from navtool.base.files import read_json, write_json
from navtool.datasets.store.layout import Layout

_PATIENCE_S = 1.0
_SUFFIX = ".new"
_STAGED_IN = ("data", "meta", "navtool", "videos")
_CURE = "check the disk's space and the folder's rights, then run the command again"


def staged(target: Path) -> Path:
    """Where the new content of a file is written before it is committed; beside it, so that a rename moves it."""
    return target.with_name(target.name + _SUFFIX)


def journal_path(root: Path) -> Path:
    """The journal: while it is there, the files that it names are being replaced."""
    return Layout(root).beside / "journal.json"


def commit(
    root: Path,
    targets: Sequence[Path],
    on_replaced: Callable[[int], None] | None = None,
    *,
    remove: Sequence[Path] = (),
) -> None:
    """Replace each target by its staged file or folder. The caller holds the data set's lock.

    The journal's appearance is the one moment that counts: stopped before it, nothing has changed; stopped after it,
    ``recover`` finishes the step.

    Args:
        root: The data set.
        targets: Files or folders of the data set, each with its complete staged counterpart.
        on_replaced: Called with the number of replaced files so far, before each and at the end.
        remove: Files of the data set that do not hold any more.

    Raises:
        OutputError: If a file cannot be written.
    """
    try:
        for target in targets:
            _sync(staged(target))
        for folder in {target.parent for target in targets}:
            _sync(folder)
        names = {"files": targets, "remove": remove}
        write_json(
            journal_path(root),
            {key: [path.relative_to(root).as_posix() for path in paths] for key, paths in names.items()},
        )
        _sync(journal_path(root).parent)
    except OSError as error:
        raise OutputError(f"cannot be written ({error.strerror})", where=root, cure=_CURE) from error
    _replay(root, on_replaced)


def recover(root: Path) -> bool:
    """Finish a replacement that was interrupted; for readers, and cheap where there is none. True if there was one.

    A replacement that a living process is about to finish is waited for, but not for long.

    Raises:
        DatasetsError: If another process is writing to the data set, or the journal is damaged.
        OutputError: If a file cannot be written.
    """
    patience = time.monotonic() + _PATIENCE_S
    while journal_path(root).exists():
        try:
            with take_lock(Layout(root).lock):
                return finish(root)
        except BlockingIOError as error:
            if time.monotonic() > patience:
                cure = "wait until it is done"
                raise DatasetsError("another process is writing to it", where=root, cure=cure) from error
            time.sleep(0.02)
        except OSError as error:
            raise OutputError(f"cannot be written ({error.strerror})", where=root, cure=_CURE) from error
    return False


def finish(root: Path) -> bool:
    """Like ``recover``, for a caller that holds the data set's lock; also removes staged files without a journal.

    Raises:
        DatasetsError: If the journal is damaged.
        OutputError: If a file cannot be written.
    """
    pending = _replay(root)
    try:
        for folder in _STAGED_IN:
            for left in list((root / folder).rglob(f"*{_SUFFIX}")):
                if left.is_dir():
                    shutil.rmtree(left)
                else:
                    left.unlink(missing_ok=True)
    except OSError as error:
        raise OutputError(f"cannot be written ({error.strerror})", where=root, cure=_CURE) from error
    return pending


def _replay(root: Path, on_replaced: Callable[[int], None] | None = None) -> bool:
    """Do what the journal says, and take it away; whether there was one."""
    announce = on_replaced or _ignore
    journal = journal_path(root)
    pending = journal.exists()
    try:
        if pending:
            targets, removed = _targets(root)
            for number, target in enumerate(targets):
                announce(number)
                if staged(target).exists():
                    if target.is_dir():
                        shutil.rmtree(target)
                    staged(target).replace(target)
            for path in removed:
                path.unlink(missing_ok=True)
            announce(len(targets))
            for parent in {target.parent for target in targets}:
                _sync(parent)
            journal.unlink()
            _sync(journal.parent)
    except OSError as error:
        raise OutputError(f"cannot be written ({error.strerror})", where=root, cure=_CURE) from error
    return pending


def _targets(root: Path) -> tuple[list[Path], list[Path]]:
    """What the journal says is replaced, and what is removed."""
    content = read_json(journal_path(root), "restore the data set from a copy")
    names, gone = content.get("files"), content.get("remove", [])
    targets = [root / str(name) for name in names] if isinstance(names, list) else []
    removed = [root / str(name) for name in gone] if isinstance(gone, list) else []
    outside = [path for path in (*targets, *removed) if not path.resolve().is_relative_to(root.resolve())]
    if not targets or outside:
        raise DatasetsError(
            f"names {outside[0]}, outside of the data set" if outside else "names no files",
            where=journal_path(root),
            cure="restore the data set from a copy",
        )
    return targets, removed


def _sync(path: Path) -> None:
    descriptor = os.open(path, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _ignore(_number: int) -> None:
    return None
