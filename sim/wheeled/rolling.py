"""How the drives push the robot over a ground that resists: speeds, slip, what winds around the axles, and power."""

import math
from typing import NamedTuple

from navtool.sim.wheeled.config import STEP_S, WheeledConfig

WOUND_HOLDS = 1.0
"""Force over weight for what has wound itself around the axles, in units of the drag it comes from. Chosen: a robot is
held after about three metres of tall grass as dense as a patch's middle, and passes thinner or shorter patches."""
UNWINDS_M = 4.0
"""Way over which stems wind off again. Chosen."""
_FIRM = 0.03
"""Rolling resistance below this is hard ground's."""
_HOLDS_SHARE, _HELD_SPEED = 0.3, 0.5
"""Held is who reaches neither half of the speed nor half of the turn asked for, while something soft takes this share
of the force there is."""
_STILL_MPS = 0.02


class Under(NamedTuple):
    """What is under the wheels now: means over the left and the right ones, and over all."""

    load_n: tuple[float, float]
    """On the left and the right wheels."""
    friction: tuple[float, float]
    rolling: tuple[float, float]
    """Resistance over load."""
    uphill: float
    """Rise of the ground along the heading."""
    drag_per_m: float
    """Share of its speed that ground and plants take in a metre."""
    plants_per_m: float
    """That of plants alone."""


class Rolling:
    """Forward speed and turn of a robot whose sides are driven, in steps of ``STEP_S``.

    Forces of the drives are limited by their motors and by the tyres' grip; resistance is Coulomb's, so that it stops
    the robot and never pushes it.
    """

    def __init__(self, config: WheeledConfig) -> None:
        self._config = config
        self.reset()

    def reset(self) -> None:
        """Stand still."""
        self.speed_mps = self.turn_radps = 0.0
        self.wheel_mps = [0.0, 0.0]
        """Speeds of the left and the right wheels' rims."""
        self.force_n = [0.0, 0.0]
        """With which the left and the right drive push."""
        self.power_w = self._config.idle_w
        """Drawn from the battery."""
        self.lost_w = 0.0
        """What becomes heat in drives and electronics: the power drawn, less the work that the wheels do."""
        self.spins = False
        """Whether tyres slide because the drives push harder than they grip."""
        self.held = False
        self._asked = [0.0, 0.0]
        self._wound = 0.0

    def step(self, speed_mps: float, turn_radps: float, under: Under, *, freed: bool) -> None:
        """Follow a command for a step."""
        c = self._config
        asked = self._asked
        change, most = speed_mps - asked[0], c.acceleration_mps2 * STEP_S
        asked[0] += max(-most, min(most, change))
        change, most = turn_radps - asked[1], c.turn_acceleration_radps2 * STEP_S
        asked[1] += max(-most, min(most, change))
        speed, turn, half = self.speed_mps, self.turn_radps, 0.5 * c.track_m
        left_n, right_n = under.load_n
        rolling = (_FIRM, _FIRM) if freed else under.rolling
        resist_left, resist_right = rolling[0] * left_n, rolling[1] * right_n
        if freed:
            self._wound, wound_n, drag_n = 0.0, 0.0, 0.0
        else:
            wound_n = WOUND_HOLDS * abs(self._wound) * (left_n + right_n)
            drag_n = c.mass_kg * under.drag_per_m * speed * speed
        grade_n = (left_n + right_n) * under.uphill
        # on the spot the wheels roll against the turn, straight on against the way
        rim = half * abs(turn)
        turning = rim / (rim + abs(speed) + 1e-3)
        rolls_n = resist_left + resist_right + wound_n
        straight_n = rolls_n * (1.0 - turning) + drag_n
        sideways = 0.5 * c.wheel_base_m * abs(turn)
        dragged = sideways / (sideways + c.scrub_angle * (abs(speed) + rim) + 1e-6)
        grip_left, grip_right = under.friction[0] * left_n, under.friction[1] * right_n
        scrub_nm = c.scrub_share * (grip_left + grip_right) * 0.5 * c.wheel_base_m * dragged + rolls_n * turning * half
        want_n = c.mass_kg * (asked[0] - speed) / c.lag_s + grade_n + _sign(speed, asked[0], _STILL_MPS) * straight_n
        want_nm = c.yaw_inertia_kgm2 * (asked[1] - turn) / c.lag_s + _sign(turn, asked[1], 0.02) * scrub_nm
        wants = 0.5 * want_n - 0.5 * want_nm / half, 0.5 * want_n + 0.5 * want_nm / half
        most_left, most_right = min(grip_left, c.side_force_n), min(grip_right, c.side_force_n)
        left = max(-most_left, min(most_left, wants[0]))
        right = max(-most_right, min(most_right, wants[1]))
        self.force_n[0], self.force_n[1] = left, right
        free = speed + STEP_S * (left + right - grade_n) / c.mass_kg
        self.speed_mps = _slowed(free, STEP_S * straight_n / c.mass_kg)
        free = turn + STEP_S * (right - left) * half / c.yaw_inertia_kgm2
        self.turn_radps = _slowed(free, STEP_S * scrub_nm / c.yaw_inertia_kgm2)
        self._turn_wheels(wants, (grip_left, grip_right))
        soft_n = wound_n + drag_n + max(resist_left + resist_right - _FIRM * (left_n + right_n), 0.0)
        slow = abs(self.speed_mps) < _HELD_SPEED * abs(asked[0]) if abs(asked[0]) > 0.05 else abs(asked[1]) > 0.1
        slow = slow and abs(self.turn_radps) <= _HELD_SPEED * max(abs(asked[1]), 0.1)
        self.held = not freed and slow and soft_n > _HOLDS_SHARE * (most_left + most_right)
        if under.plants_per_m > 0.0 or self._wound:
            way = 0.5 * (self.wheel_mps[0] + self.wheel_mps[1]) * STEP_S
            self._wound += under.plants_per_m * way - self._wound * abs(way) / UNWINDS_M

    def _turn_wheels(self, wants: tuple[float, float], grip: tuple[float, float]) -> None:
        """Let the wheels turn as they grip or slide, and draw the power."""
        c = self._config
        across = 0.5 * c.track_m * c.track_multiplier
        power, lost, self.spins = c.idle_w, c.idle_w, False
        for side, sign in ((0, -1.0), (1, 1.0)):
            force, most = self.force_n[side], grip[side]
            over_ground = self.speed_mps + sign * across * self.turn_radps
            if abs(wants[side]) > most and most < c.side_force_n:
                self.spins = True
                asked = self._asked[0] + sign * across * self._asked[1]
                self.wheel_mps[side] += (asked - self.wheel_mps[side]) * STEP_S / c.lag_s
            else:
                slip = force * math.copysign(1.0, over_ground) / (c.slip_stiffness * most / 0.8 + 1.0)
                self.wheel_mps[side] = over_ground * (1.0 + slip)
            work = force * self.wheel_mps[side]
            heat = c.winding_loss_w_per_n2 * force * force
            # a drive that brakes heats its own windings first; what is left over is not fed back
            drawn = heat + work / c.efficiency if work > 0 else max(heat + work * c.efficiency, 0.0)
            power += drawn
            lost += drawn - work
        self.power_w, self.lost_w = power, lost


def _sign(now: float, asked: float, still: float) -> float:
    """Which way it goes, or is to go while it stands."""
    value = now if abs(now) > still else asked
    return 1.0 if value > 0 else -1.0 if value < 0 else 0.0


def _slowed(free: float, most: float) -> float:
    """A speed that Coulomb's friction has braked, at most to rest."""
    return max(free - most, 0.0) if free > 0 else min(free + most, 0.0)
