"""The friction that the controller counts on, as its feet have felt it."""

from collections.abc import Sequence

from navtool.sim.legged.controller_config import CONTROL_S

FIRM = 0.55
"""Counted on until a foot slides; most that is ever counted on."""
LEAST = 0.2
"""Least that is ever counted on: a robot that may not push at all cannot keep its balance."""
SLIDES_MPS = 0.2
"""A foot that carries and is faster than this slides: twice what any foot does that rolls, lands or settles on level
concrete."""
_LOADED_N = 25.0
_SURE_TICKS = 8
"""For so many decisions in a row a foot has to slide: on stones feet that roll off an edge or knock do so for up to
about 0.03 s, in mud they slide for longer."""
_SHARE = 0.95
"""Share that is counted on of the ratio of forces at which a foot slid."""
_FALL_S, _RECOVER_S = 0.04, 4.0
"""Time constants with which it falls towards that, and comes back to `FIRM`."""


class FeltGrip:
    """Learns how far a foot may be pushed across the ground from feet that slide under load.

    A foot that slides shows that the ground holds less than the ratio of forces that was asked of it: what is counted
    on falls at once below that ratio, for all feet, for where one slid the next one comes down. While none slides it
    comes back slowly, to find out whether the ground is better by now. It lies within `LEAST` and `FIRM`, and is
    exactly `FIRM` until the first foot slides. It never sees the ground's true friction.
    """

    def __init__(self) -> None:
        self.friction = FIRM
        """Ratio of a foot's force along the ground to that across it, at most."""
        self._sliding_ticks = [0] * 4

    def feel(
        self, speed_mps: Sequence[float], force_n: Sequence[float], asked: Sequence[float], standing: Sequence[bool]
    ) -> None:
        """Take in what the feet did since the last decision, `CONTROL_S` ago.

        Args:
            speed_mps: How fast each foot moves along the ground, by leg.
            force_n: How hard each presses.
            asked: Ratio of the force along the ground to that across it that was asked of each; 0 of one in the air.
            standing: Which are meant to stand.
        """
        slid = []
        for leg in range(4):
            slides = standing[leg] and force_n[leg] > _LOADED_N and speed_mps[leg] > SLIDES_MPS
            self._sliding_ticks[leg] = self._sliding_ticks[leg] + 1 if slides else 0
            if self._sliding_ticks[leg] >= _SURE_TICKS:
                slid.append(asked[leg])
        if slid:
            short = min(0.0, _SHARE * max(slid) - self.friction)
            self.friction = max(LEAST, self.friction + CONTROL_S / _FALL_S * short)
        else:
            self.friction += CONTROL_S / _RECOVER_S * (FIRM - self.friction)
