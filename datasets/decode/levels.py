"""Pictures of 16 bits a sample, of which a camera uses 10, 12 or 14, or a thermal one a narrow band: what is shown."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from jaxtyping import Shaped, UInt8, UInt16

from navtool.pipeline.arrays import Array

SURVEY_NS = 3_000_000_000
"""For so long from its first picture on a recording's pictures say what range they have."""
_EVERY_NS = 200_000_000
_FULL = 65_535
_DEPTHS = (8, 10, 12, 14, 16)
_USED_SHARE = 0.25
"""A camera uses at least so much of a bit depth's range; a narrower band is a thermal camera's."""
_MARGIN = 0.25
"""How far beyond the band that was seen brightness goes on growing, as a share of the band."""
_OUTSIDE_SHARE = 0.05
_STEP = 4


@dataclass(frozen=True)
class Levels:
    """The samples that become black and white; brightness grows in proportion between."""

    low: int
    high: int

    @property
    def is_full(self) -> bool:
        """Whether they are all that 16 bits hold."""
        return (self.low, self.high) == (0, _FULL)

    @cached_property
    def table(self) -> UInt8[Array, " 65536"]:
        """Brightness of each sample; a whole bit depth keeps its upper 8 bits."""
        samples = np.arange(_FULL + 1)
        bits = (self.high + 1).bit_length() - 1
        if self.low == 0 and self.high == (1 << bits) - 1 and bits >= 8:
            return np.asarray(np.minimum(samples >> (bits - 8), 255), np.uint8)
        share = (samples - self.low) / max(self.high - self.low, 1)
        return np.asarray(np.rint(np.clip(share, 0, 1) * 255), np.uint8)

    def outside(self, samples: UInt16[Array, "h w *channels"]) -> bool:
        """Whether more than 5 % of a picture are beyond black and white, of those that are looked at."""
        seen = samples[::_STEP, ::_STEP]
        return bool(np.mean((seen < self.low) | (seen > self.high)) > _OUTSIDE_SHARE)


FULL = Levels(0, _FULL)


@dataclass(frozen=True, eq=False)
class Deep:
    """The samples of a picture of 16 bits, and the way to colours once there are 8."""

    samples: UInt16[Array, "h w *channels"]
    to_rgb: Callable[[Any], Any]

    def rgb(self, levels: Levels) -> UInt8[Array, "h w 3"]:
        """The picture at these levels."""
        # A look-up table costs as much as a shift.
        return np.asarray(self.to_rgb(levels.table[self.samples]), np.uint8)


@dataclass(slots=True)
class LevelSurvey:
    """The range of a recording's pictures over its first seconds."""

    first_ns: int
    _last_ns: int = -(1 << 62)
    _lows: list[float] = field(default_factory=list)
    _highs: list[float] = field(default_factory=list)
    _peak: int = 0

    def wants(self, record_ns: int) -> bool:
        """Whether the picture of that time of record is to be added: a few a second, for the first seconds."""
        return record_ns - self.first_ns <= SURVEY_NS and record_ns - self._last_ns >= _EVERY_NS

    def add(self, samples: Shaped[Array, "h w *channels"], record_ns: int) -> None:
        """Look at a picture's samples."""
        seen = samples[::_STEP, ::_STEP]
        low, high = np.quantile(seen, (0.001, 0.999))
        self._lows.append(float(low))
        self._highs.append(float(high))
        self._peak = max(self._peak, int(seen.max()))
        self._last_ns = record_ns

    def levels(self) -> Levels:
        """What the pictures use: a bit depth where they use a fair part of one, else the band that they lie in."""
        if not self._lows:
            return FULL
        low, high = min(self._lows), max(self._highs)
        top = (1 << next(bits for bits in _DEPTHS if self._peak < 1 << bits)) - 1
        if high - low >= _USED_SHARE * top or high - low < 1:
            return Levels(0, top)
        margin = _MARGIN * (high - low)
        return Levels(max(0, round(low - margin)), min(_FULL, round(high + margin)))


def levels_of(pictures: Sequence[Shaped[Array, "h w *channels"]]) -> Levels:
    """The levels of a few pictures together."""
    survey = LevelSurvey(0)
    for samples in pictures:
        survey.add(samples, 0)
    return survey.levels()
