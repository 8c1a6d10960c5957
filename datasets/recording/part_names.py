"""Bag files by their names: which are numbered parts of one recording, which are packed copies of each other."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

import zstandard

from navtool.base.errors import DatasetsError
from navtool.base.note import Note
from navtool.datasets.recording.file_compression import unpacked_bytes

_BAG_FILE = re.compile(r".*\.(bag|db3|mcap)(\.zstd)?")
# Recorders write numbers without leading zeros; 000, 001 are a user's runs.
_PART = re.compile(r"(?P<stem>.+)_(?P<part>0|[1-9]\d*)(?P<suffix>\.(bag|db3|mcap))")
_DATE = re.compile(r"\d{4}(-\d{2}){5}$")
"""What ROS 1 writes before the number of a part: when it began, so that it differs from part to part."""
_PACKED = ".zstd"
_HEAD_BYTES = 32


class Chosen(NamedTuple):
    """A bag file, of which a packed copy may lie beside it."""

    file: Path
    notes: tuple[Note, ...] = ()


def is_bag_file(path: Path) -> bool:
    """Whether a file is named like a recording."""
    return bool(_BAG_FILE.fullmatch(path.name)) and path.is_file()


def bare_name(path: Path) -> str:
    """The file's name without what says that it is packed as a whole."""
    return path.name.removesuffix(_PACKED)


def pattern_of(path: Path) -> str | None:
    """What the parts of a split recording are called alike, such as ``run_*.db3``; None for a file without a number."""
    match = _PART.fullmatch(bare_name(path))
    if match is None:
        return None
    stem = _DATE.sub("*", match["stem"]) if match["suffix"] == ".bag" else match["stem"]
    return f"{stem}_*{match['suffix']}"


def number_of(path: Path) -> int:
    """The number of a part; -1 for a file without one."""
    match = _PART.fullmatch(bare_name(path))
    return -1 if match is None else int(match["part"])


def without_copies(files: Iterable[Path]) -> list[Chosen]:
    """Each file once, where it lies packed and unpacked side by side the one that is whole; by name."""
    by_name: dict[str, list[Path]] = {}
    for file in sorted(files):
        by_name.setdefault(bare_name(file), []).append(file)
    return [Chosen(found[0]) if len(found) == 1 else _whole_one(*found[:2]) for found in by_name.values()]


def consecutive(parts: Sequence[Path]) -> bool:
    """Whether files have numbers one behind the other, whatever the first."""
    numbers = [number_of(part) for part in parts]
    return numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def _whole_one(plain: Path, packed: Path) -> Chosen:
    try:
        size = plain.stat().st_size
        with packed.open("rb") as stream:
            stated = zstandard.frame_content_size(stream.read(_HEAD_BYTES))
    except (OSError, zstandard.ZstdError):
        return Chosen(plain, (_note(plain, packed, "which cannot be unpacked"),))
    if stated == size:
        return Chosen(plain, (_note(plain, packed, "which says that it holds as many bytes"),))
    try:
        held = unpacked_bytes(packed)
    except DatasetsError:
        return Chosen(plain, (_note(plain, packed, "which is torn"),))
    if held > size:
        return Chosen(packed, (_note(packed, plain, "which is not all of it"),))
    return Chosen(plain, (_note(plain, packed, f"which holds {'as many' if held == size else 'fewer'} bytes"),))


def _note(read: Path, left: Path, why: str) -> Note:
    return Note("recording.copies", f"{read.name} is read, and not {left.name} beside it, {why}")
