"""Small file systems of their own, to be filled and to be made read-only; they need the right to mount."""

import errno
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

_PIECE = 1 << 16


class SmallDisk:
    """A mounted file system."""

    def __init__(self, place: Path) -> None:
        self.place = place
        self._filler = place / "filler"

    def fill(self) -> None:
        """Leave not a byte."""
        with self._filler.open("ab", buffering=0) as file:
            size = _PIECE
            while size:
                try:
                    file.write(bytes(size))
                except OSError as error:
                    if error.errno != errno.ENOSPC:
                        raise
                    size //= 2

    def free(self) -> None:
        """Take away what `fill` wrote."""
        self._filler.unlink(missing_ok=True)

    def remount(self, mode: str) -> None:
        """Mount it again, as ``ro`` or ``rw``."""
        _run("mount", "-o", f"remount,{mode}", str(self.place))


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Callable[[int], SmallDisk]]:
    """``small_disk(mebibytes) -> SmallDisk``, mounted for the time of a test; skips where mounting is not allowed."""
    places: list[Path] = []

    def mount(mebibytes: int) -> SmallDisk:
        place = tmp_path / f"disk-{len(places)}"
        place.mkdir()
        said = _run("mount", "-t", "tmpfs", "-o", f"size={mebibytes}m", "tmpfs", str(place))
        if said:
            pytest.skip(f"cannot mount a small file system: {said}")
        places.append(place)
        return SmallDisk(place)

    yield mount
    for place in places:
        assert _run("umount", str(place)) == ""


def _run(*command: str) -> str:
    """What the command says of its failure; empty where it succeeds."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    return "" if done.returncode == 0 else done.stderr.strip() or "it failed"
