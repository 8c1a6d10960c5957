"""Damaged copies of recordings, and processes that may not fill the memory while they read them."""

import os
import resource
from collections.abc import Iterator
from pathlib import Path

import numpy as np

MEMORY_BYTES = 2 << 30
LENGTHS = (0, 1, 0x7FFFFFFF, 0xFFFFFFFF, 1 << 40, (1 << 64) - 1)


def damaged(data: bytes, rng: np.random.Generator) -> bytes:
    """One kind of damage, somewhere."""
    changed = bytearray(data)
    place, size = int(rng.integers(len(data))), int(rng.integers(1, max(len(data) // 8, 2)))
    match int(rng.integers(6)):
        case 0:
            for _ in range(int(rng.integers(1, 20))):
                changed[int(rng.integers(len(data)))] ^= 1 << int(rng.integers(8))
        case 1:
            del changed[place:]
        case 2:
            other = int(rng.integers(len(data)))
            changed[place : place + size], changed[other : other + size] = (
                changed[other : other + size],
                changed[place : place + size],
            )
        case 3:
            width = int(rng.choice([4, 8]))
            length = LENGTHS[int(rng.integers(len(LENGTHS)))] % (1 << 8 * width)
            changed[place : place + width] = length.to_bytes(width, "little")
        case 4:
            changed[place : place + size] = bytes(size)
        case _:
            changed[place:place] = changed[place : place + size]
    return bytes(changed)


def copies(file: Path, folder: Path, number: int, seed: int = 0) -> Iterator[Path]:
    """Damaged copies of a file, each with its own damage."""
    data = file.read_bytes()
    rng = np.random.default_rng((len(data), seed))
    for index in range(number):
        path = folder / f"{index}{''.join(file.suffixes)}"
        path.write_bytes(damaged(data, rng))
        yield path


def limit_memory() -> None:
    """No more than two gibibytes beyond what this process has taken already."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY_BYTES, used + MEMORY_BYTES))
