"""Where chance comes from: one generator a purpose, so that parts of a world do not disturb each other."""

from enum import IntEnum
from zlib import crc32

import numpy as np


class Purpose(IntEnum):
    """What a generator is for. Numbers are never reused: they are part of what a seed means."""

    RELIEF = 1
    REGIONS = 2
    PLACEMENT = 3
    TREES = 4
    HANGING_TREES = 5
    BUSHES = 6
    GRASS = 7
    ROCKS = 8
    WALLS = 9
    PILLARS = 10
    GLASS = 11
    CURTAINS = 12
    ROOM = 13
    LIGHT = 14
    COURSE = 15
    SKY = 16
    SHADE = 17
    DIRT = 18


def generator(place: str, seed: int, purpose: Purpose, index: int = 0) -> np.random.Generator:
    """A generator that depends on the arguments alone, in every process."""
    return np.random.default_rng([crc32(place.encode()), seed, int(purpose), index])
