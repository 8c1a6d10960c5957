"""Recordings that lie elsewhere: object stores, web servers, whatever fsspec reaches; fetched once and kept."""

import hashlib
import os
import re
import shutil
import socket
from collections.abc import Callable, Sequence
from glob import glob
from itertools import takewhile
from pathlib import Path
from typing import Any, NamedTuple

from navtool.base.errors import DatasetsError, OutputError
from navtool.base.meter import Meter
from navtool.base.progress import Progress, Silent
from navtool.datasets.recording.foreign import describe

_REMOTE = re.compile(r"^[a-z][a-z0-9+.-]+://", re.IGNORECASE)
_SUFFIXES = (".bag", ".mcap", ".db3", ".zstd", ".yaml")
_PIECE = 1 << 22


def default_cache() -> Path:
    """Where fetched recordings are kept: ``navtool/recordings`` in the user's cache folder."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "navtool" / "recordings"


def is_url(text: str) -> bool:
    """Whether an input lies elsewhere."""
    return bool(_REMOTE.match(text))


def local_paths(inputs: Sequence[str], cache: Path, progress: Progress | None = None) -> list[Path]:
    """The paths that a user's inputs stand for; what is remote is fetched into the cache, once all inputs are found.

    Args:
        inputs: Paths, glob patterns, or URLs such as ``s3://bucket/runs/*.mcap`` of files, folders or patterns.
        cache: Where fetched files go, each below a folder of its URL's hash. One that is there already with its full
            size is not fetched again.
        progress: Learns how many files and bytes are fetched.

    Raises:
        DatasetsError: A pattern matches nothing, or a URL cannot be reached or holds no recording.
        OutputError: The cache cannot be written.
    """
    paths: list[Path] = []
    missing: list[_RemoteFile] = []
    for text in inputs:
        if is_url(text):
            path, files = _listed(text, cache)
            paths.append(path)
            missing += [file for file in files if not file.is_there()]
        else:
            paths += _local(text)
    if missing:
        _fetch_all(missing, progress or Silent())
    return paths


def _local(text: str) -> list[Path]:
    if Path(text).exists() or not re.search(r"[*?\[]", text):
        return [Path(text)]
    found = sorted(glob(text, recursive=True))  # noqa: PTH207 - whole paths, absolute ones too
    if not found:
        raise DatasetsError("no file matches the pattern", where=text, cure="check it; quote it for **")
    return [Path(entry) for entry in found]


class _RemoteFile(NamedTuple):
    """A file that lies elsewhere, and where it is fetched to."""

    system: Any
    name: str
    size: int
    """Bytes; 0 where a server does not say."""
    url: str
    """What the user wrote."""
    target: Path

    def is_there(self) -> bool:
        """Whether it was fetched before, whole."""
        return self.target.is_file() and self.target.stat().st_size == self.size


def _listed(url: str, cache: Path) -> tuple[Path, list[_RemoteFile]]:
    """Where what lies at a URL is fetched to, and the files of it."""
    system, location = _system(url)
    try:
        names = _files(system, location)
        sizes = [int(system.size(name) or 0) for name in names]
    except Exception as error:
        raise _unreachable(url, error) from error
    if not names:
        cure = f"name a file, a folder or a pattern of recordings ({', '.join(_SUFFIXES[:3])})"
        raise DatasetsError("no recording there", where=url, cure=cure)
    base = cache / hashlib.sha256(url.encode()).hexdigest()[:16]
    root = location.rstrip("/").rpartition("/")[0] if len(names) == 1 else _common(names)
    folder = base / (root.rpartition("/")[2] or "files")
    targets = [_inside(folder / name.removeprefix(root).lstrip("/"), base) for name in names]
    files = [
        _RemoteFile(system, name, size, url, target) for name, size, target in zip(names, sizes, targets, strict=True)
    ]
    return targets[0] if len(targets) == 1 else folder, files


def _fetch_all(files: Sequence[_RemoteFile], progress: Progress) -> None:
    progress.begin(len(files), sum(file.size for file in files))
    for number, file in enumerate(files, 1):
        with Meter(file.size, progress.advance) as meter:
            _fetch(file, meter.part(0, file.size))
        progress.done(number, file.name)


def _system(url: str) -> tuple[Any, str]:
    import fsspec  # noqa: PLC0415 - only those who fetch pay for it

    try:
        system, location = fsspec.core.url_to_fs(url)
    except ImportError as error:
        raise DatasetsError(
            f"needs another package: {describe(error)}", where=url, cure="install the package that it names"
        ) from error
    except ValueError as error:
        raise DatasetsError(f"{describe(error)}", where=url, cure="use a protocol that fsspec knows") from error
    return system, str(location)


def _files(system: Any, location: str) -> list[str]:
    if re.search(r"[*?\[]", location):
        found = [name for name in system.glob(location) if not system.isdir(name)]
    elif location.endswith(_SUFFIXES) or not system.isdir(location):
        system.info(location)  # says why not, where `exists` would only say that it is not
        return [location]
    else:
        found = system.find(location)
    return sorted(name for name in found if name.endswith(_SUFFIXES))


def _common(names: Sequence[str]) -> str:
    """The folder of all of them, spelled as they spell it: of ``http://`` not one slash may be lost."""
    levels = zip(*(name.split("/")[:-1] for name in names), strict=False)
    return "/".join(level[0] for level in takewhile(lambda level: len(set(level)) == 1, levels))


def _inside(target: Path, base: Path) -> Path:
    """The target, which may not lie outside of its folder whatever a server calls its files."""
    if not target.resolve().is_relative_to(base.resolve()):
        raise DatasetsError("its name leads out of the folder that it is fetched into", where=str(target))
    return target


def _fetch(file: _RemoteFile, on_reached: Callable[[int], None]) -> None:
    target, url = file.target, file.url
    part = target.with_name(f".{target.name}.part")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with part.open("wb") as out:
            fetched = 0
            with file.system.open(file.name, "rb") as remote:
                while piece := _read(remote, url):
                    out.write(piece)
                    fetched += len(piece)
                    on_reached(fetched)
            out.flush()
            os.fsync(out.fileno())
        if file.size and fetched != file.size:
            raise DatasetsError(f"{fetched} of {file.size} bytes came", where=url, cure="run the command again")
        shutil.move(part, target)
    except DatasetsError:
        part.unlink(missing_ok=True)
        raise
    except OSError as error:
        part.unlink(missing_ok=True)
        raise OutputError(
            f"cannot be fetched ({describe(error)})", where=target, cure="check space and rights"
        ) from error


def _read(remote: Any, url: str) -> bytes:
    try:
        return bytes(remote.read(_PIECE))
    except Exception as error:
        raise _unreachable(url, error) from error


def _unreachable(url: str, error: Exception) -> DatasetsError:
    """Why a URL cannot be read, by the innermost error that says it."""
    chain = [error]
    while (inner := chain[-1].__cause__ or chain[-1].__context__) is not None and isinstance(inner, Exception):
        chain.append(inner)
    # Libraries keep what the operating system said as an attribute.
    chain += [entry for error in chain if isinstance(entry := getattr(error, "os_error", None), Exception)]
    for entry in reversed(chain):
        if (refusal := _refusal(entry)) is not None:
            what, cure = refusal
            return DatasetsError(what, where=url, cure=cure)
    cure = "check the address, the network and your credentials"
    return DatasetsError(f"cannot be read: {describe(error)}", where=url, cure=cure)


def _refusal(error: Exception) -> tuple[str, str] | None:
    """What an error says of a URL, and the cure; None where it says nothing that is known."""
    status = getattr(error, "status", None)
    if isinstance(error, ConnectionRefusedError):
        return "the connection was refused", "check the port, and whether the server runs"
    if isinstance(error, socket.gaierror):
        return "there is no such host", "check the address, and that this machine can look names up"
    if isinstance(error, TimeoutError):
        return "the server did not answer in time", "check the network, and run the command again"
    if status in (401, 403) or isinstance(error, PermissionError):
        return "access was denied", "check your credentials and rights"
    if status in (404, 410) or type(error) is FileNotFoundError:
        return "there is nothing at this address", "check its spelling"
    return None if not isinstance(status, int) else (f"the server answered with status {status}", "try again later")
