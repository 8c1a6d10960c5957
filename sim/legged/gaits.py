"""The gaits: which foot is on the ground when, and how high and how often the others step."""

import math
from dataclasses import dataclass
from enum import Enum

from navtool.sim.errors import SimError

_TURN = 2 * math.pi
_SIDES = (1, -1, 1, -1)


class GaitName(Enum):
    """The three gaits of AMCO's robot (AMCO III-B)."""

    TROT = "trot"
    """Two feet on the ground."""
    CRAWL = "crawl"
    """Three feet or four on the ground, at a low speed."""
    AMBLE = "amble"
    """The crawl's order of feet at any speed."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Gait:
    """A periodic order of steps, by leg in the order of `body.LEGS`."""

    name: GaitName
    period_s: float
    """Duration of one stride; above 0."""
    duty: float
    """Share of the stride that a foot is on the ground, 0-1."""
    offsets: tuple[float, float, float, float]
    """Share of the stride at which each foot comes down."""
    step_height_m: float
    """How far a foot is lifted above the line between its footprints."""
    top_speed_mps: float
    """Commands are limited to this."""
    sway_m: float
    """How far the body leans to the side while the feet of the other side step; 0 or more."""
    margin_m: float = 0.0
    """How far inside its other three feet the body is kept when one steps, 0 or more; 0 lets it fall towards the
    stepping foot, as gaits with two feet in the air have to."""

    def __post_init__(self) -> None:
        if self.period_s <= 0 or not 0.0 < self.duty < 1.0:
            what = f"a gait with a period of {self.period_s} s and a duty factor of {self.duty}"
            raise SimError(what, cure="the period must be above 0 and the duty factor between 0 and 1")

    @property
    def stance_s(self) -> float:
        """How long a foot stands."""
        return self.duty * self.period_s

    @property
    def swing_s(self) -> float:
        """How long a foot is in the air."""
        return (1.0 - self.duty) * self.period_s

    def sway(self, phase: float) -> tuple[float, float, float]:
        """Return how far to the left the body leans at a phase (0-1), and the speed and acceleration of that.

        It goes to and fro once a stride, away from the side whose feet step; where left and right feet step together,
        as in a trot, there is no such side and no sway.
        """
        turns = [_TURN * (offset - 0.5 * (1.0 - self.duty)) for offset in self.offsets]
        cosine = sum(side * math.cos(turn) for side, turn in zip(_SIDES, turns, strict=True))
        sine = sum(side * math.sin(turn) for side, turn in zip(_SIDES, turns, strict=True))
        size = math.hypot(cosine, sine)
        if self.sway_m == 0.0 or size < 1e-9:
            return 0.0, 0.0, 0.0
        angle, rate = _TURN * phase - math.atan2(sine, cosine), _TURN / self.period_s
        lean = self.sway_m * math.cos(angle)
        return -lean, self.sway_m * rate * math.sin(angle), rate * rate * lean


GAITS = {
    GaitName.TROT: Gait(
        name=GaitName.TROT,
        period_s=0.56,
        duty=0.58,
        offsets=(0.0, 0.5, 0.5, 0.0),
        step_height_m=0.10,
        top_speed_mps=1.2,
        sway_m=0.0,
    ),
    GaitName.CRAWL: Gait(
        name=GaitName.CRAWL,
        period_s=1.5,
        duty=0.82,
        offsets=(0.25, 0.75, 0.0, 0.5),
        step_height_m=0.11,
        top_speed_mps=0.35,
        sway_m=0.045,
        margin_m=0.06,
    ),
    GaitName.AMBLE: Gait(
        name=GaitName.AMBLE,
        period_s=0.84,
        duty=0.70,
        offsets=(0.25, 0.75, 0.0, 0.5),
        step_height_m=0.10,
        top_speed_mps=0.8,
        sway_m=0.025,
    ),
}
"""A hind foot comes down, then the front foot of the same side, then the other side: the order in which four-legged
animals walk, which keeps the body above its feet at duty factors of 0.75 and more."""
