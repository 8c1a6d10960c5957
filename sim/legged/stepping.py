"""Which leg does what: the phase table, and how a leg answers when the ground comes early, late or in between."""

from enum import Enum

from navtool.sim.legged.controller_config import CONTROL_S, ControllerConfig
from navtool.sim.legged.gaits import Gait
from navtool.sim.legged.swing import Swing

_EARLY = 0.6
"""From this share of a step on, what a foot meets is taken for the ground."""
_CAUGHT = 0.25
"""From this share of a step on, what a foot meets is an obstacle; before it, the foot has not left its print yet."""
_LIFT_M, _MOST_LIFT_M = 0.02, 0.14
_ROUGH = 0.85
"""A foot that meets the ground before this share of its step has met a rise that nobody knew of."""
_CAUTION_M, _CAUTION_S = 0.04, 6.0
"""After such a step feet are lifted by up to this much more, which fades with this time constant."""
_HAND_ON_S = 0.04
"""How long a foot takes to take up its load and to pass it on."""
_LEAST_TRUST = 1e-3


class LegMode(Enum):
    """What a leg is doing."""

    STANCE = 0
    """It carries the body."""
    SWING = 1
    """It steps."""
    REACH = 2
    """Its step is over, and it feels for the ground."""


class Stepping:
    """Moves the legs through the gait's table.

    A foot that meets the ground early stands; one that does not find it reaches down until it does; one that is
    caught in the middle of its step is lifted higher, and the stumble is counted. After early and caught feet all
    feet are lifted higher for a while: where one stone is, there are more.
    """

    def __init__(self, gait: Gait, config: ControllerConfig) -> None:
        self.gait = gait
        self._config = config
        self.phase = 0.0
        self.walking = False
        self.modes = [LegMode.STANCE] * 4
        self.stumbles = 0
        """Steps that were caught on something so far."""
        self._caution = 0.0
        self.swings = [Swing((0.0, 0.0, 0.0), 0.0) for _ in range(4)]
        self.reach = [(0.0, 0.0, 0.0)] * 4
        """Where each foot that reaches feels for the ground, world frame."""

    def advance(self, feet_m: list[list[float]], touching: list[bool], *, wanted: bool) -> None:
        """Move the phase on by one decision and let each leg begin or end its step.

        Args:
            feet_m: Where the feet are, world frame, by leg.
            touching: Whether each presses against something.
            wanted: Whether the robot is to walk; if not, it stops once all feet stand.
        """
        self._caution *= 1.0 - CONTROL_S / _CAUTION_S
        if self.walking:
            self.phase = (self.phase + CONTROL_S / self.gait.period_s) % 1.0
        elif wanted:
            self.walking, self.phase = True, 0.0
        for leg in range(4):
            share, mode, touch = self.share(leg), self.modes[leg], touching[leg]
            if share is None:
                self._on_the_ground(leg, feet_m[leg], touch)
            elif mode is LegMode.SWING:
                self._in_the_air(leg, share, touch)
            elif mode is LegMode.REACH or (self.walking and wanted and not self.swings[leg].landed):
                self.modes[leg] = LegMode.SWING
                x, y, z = feet_m[leg]
                self.swings[leg] = Swing((x, y, z), self.gait.step_height_m + _CAUTION_M * self._caution)
        if self.walking and not wanted and all(mode is LegMode.STANCE for mode in self.modes):
            self.walking = False

    def stepping_leg(self) -> int | None:
        """Return the only leg in the air, or the next to step if all stand; None if more are in the air."""
        air = [leg for leg, mode in enumerate(self.modes) if mode is not LegMode.STANCE]
        if len(air) > 1:
            return None
        gait = self.gait
        return air[0] if air else min(range(4), key=lambda leg: (gait.offsets[leg] + gait.duty - self.phase) % 1.0)

    def share(self, leg: int) -> float | None:
        """Return how far the table has a leg's step, 0-1, or None while it has the foot on the ground."""
        phase = (self.phase - self.gait.offsets[leg]) % 1.0
        return (phase - self.gait.duty) / (1.0 - self.gait.duty) if phase >= self.gait.duty else None

    def trust(self) -> list[float]:
        """Return how much each foot may carry, 0 for one in the air to 1.

        A foot that came down early takes its load at once: the table does not know that it stands.
        """
        gait, trust = self.gait, [0.0] * 4
        for leg, mode in enumerate(self.modes):
            if mode is LegMode.STANCE:
                stood_s = gait.period_s * ((self.phase - gait.offsets[leg]) % 1.0)
                left_s = gait.stance_s - stood_s
                known = self.walking and left_s >= 0.0
                trust[leg] = max(_LEAST_TRUST, min(1.0, stood_s / _HAND_ON_S, left_s / _HAND_ON_S)) if known else 1.0
        return trust

    def _on_the_ground(self, leg: int, foot_m: list[float], touch: bool) -> None:  # noqa: FBT001
        mode, swing = self.modes[leg], self.swings[leg]
        swing.landed = False
        if touch:
            self.modes[leg] = LegMode.STANCE
        elif mode is LegMode.SWING:
            self.modes[leg] = LegMode.REACH
            x, y, z = foot_m
            self.reach[leg] = (x, y, z)
        elif mode is LegMode.REACH:
            x, y, z = self.reach[leg]
            self.reach[leg] = (x, y, z - self._config.reach_mps * CONTROL_S)

    def _in_the_air(self, leg: int, share: float, touch: bool) -> None:  # noqa: FBT001
        swing = self.swings[leg]
        if touch and share > _EARLY:
            self.modes[leg] = LegMode.STANCE
            swing.landed = True
            if share < _ROUGH:
                self._caution = min(1.0, self._caution + 0.5)
        elif touch and share > _CAUGHT:
            self.stumbles += not swing.caught
            swing.caught = True
            self._caution = 1.0
            swing.height_m = min(swing.height_m + _LIFT_M, self.gait.step_height_m + _MOST_LIFT_M)
