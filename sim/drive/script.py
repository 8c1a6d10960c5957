"""Scripted drives: orders that are held for a time, and points that are gone through."""

import math
from dataclasses import dataclass

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.sim.drive.command import DECIDE_S, Command
from navtool.sim.drive.vehicle import VehicleState

_AHEAD_M = 0.6
"""A follower aims at the point of its line that is this far ahead."""
_THERE_M = 0.3
"""It has arrived at the last point within this distance."""


@dataclass(kw_only=True, slots=True)
class Order:
    """One stretch of a scripted drive."""

    duration_s: float
    """Held for so long, rounded to ``DECIDE_S``; above 0."""
    speed_mps: float = 0.0
    """Forward, negative is backward."""
    turn_radps: float = 0.0
    """Counter-clockwise."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, math.inf, "duration_s", unit="s", above=True))


@dataclass(kw_only=True, slots=True)
class Waypoint:
    """A point to go through, world frame."""

    x_m: float
    y_m: float


class LineFollower:
    """Follows a line of points at a speed, slower the more it has to turn (pure pursuit).

    Args:
        points: Where the line goes, in metres, two or more; the first is where the robot is.
        speed_mps: On a straight line.
        turn_radps: The largest turn.
    """

    def __init__(self, points: list[tuple[float, float]], speed_mps: float, turn_radps: float) -> None:
        self._points, self._speed, self._turn = points, speed_mps, turn_radps
        self._segment, self._share = 0, 0.0

    def command(self, state: VehicleState) -> Command | None:
        """The next command; None when it has arrived at the line's end."""
        self._advance(state.x_m, state.y_m)
        last_x, last_y = self._points[-1]
        near = math.hypot(last_x - state.x_m, last_y - state.y_m) < _THERE_M
        if self._segment == len(self._points) - 2 and (near or self._share >= 1.0):
            return None
        return towards(state, self._ahead(), self._speed, self._turn)

    def _advance(self, x: float, y: float) -> None:
        """Move on along the line to what is beside the robot, never back."""
        while True:
            (a_x, a_y), (b_x, b_y) = self._points[self._segment : self._segment + 2]
            along_x, along_y = b_x - a_x, b_y - a_y
            length = along_x**2 + along_y**2
            share = 1.0 if length == 0 else ((x - a_x) * along_x + (y - a_y) * along_y) / length
            self._share = max(self._share, min(share, 1.0))
            if self._share < 1.0 or self._segment == len(self._points) - 2:
                return
            self._segment, self._share = self._segment + 1, 0.0

    def _ahead(self) -> tuple[float, float]:
        left, segment, share = _AHEAD_M, self._segment, self._share
        while True:
            (a_x, a_y), (b_x, b_y) = self._points[segment : segment + 2]
            length = math.hypot(b_x - a_x, b_y - a_y)
            rest = length * (1.0 - share)
            if rest >= left and length > 0:
                share += left / length
                return a_x + share * (b_x - a_x), a_y + share * (b_y - a_y)
            if segment == len(self._points) - 2:
                return b_x, b_y
            left, segment, share = left - rest, segment + 1, 0.0


class ScriptDriver:
    """Gives orders one after the other, and then goes through points.

    Args:
        orders: Given first.
        waypoints: Gone through from where the robot is then.
        speed_mps: Along the waypoints.
        turn_radps: The largest turn along the waypoints.
    """

    def __init__(self, orders: list[Order], waypoints: list[Waypoint], speed_mps: float, turn_radps: float) -> None:
        self._steps = [order for order in orders for _ in range(max(1, round(order.duration_s / DECIDE_S)))]
        self._points = [(point.x_m, point.y_m) for point in waypoints]
        self._limits = speed_mps, turn_radps
        self._next = 0
        self._follower: LineFollower | None = None

    def command(self, state: VehicleState) -> Command | None:
        """What is asked for now; None when the script is done."""
        if self._next < len(self._steps):
            order = self._steps[self._next]
            self._next += 1
            return Command(order.speed_mps, order.turn_radps)
        if not self._points:
            return None
        if self._follower is None:
            self._follower = LineFollower([(state.x_m, state.y_m), *self._points], *self._limits)
        return self._follower.command(state)


def towards(state: VehicleState, aim: tuple[float, float], speed_mps: float, turn_radps: float) -> Command:
    """Turn to a point and go there: on the spot when it lies aside or behind."""
    bearing = math.atan2(aim[1] - state.y_m, aim[0] - state.x_m) - state.yaw_rad
    error = math.remainder(bearing, 2 * math.pi)
    turn = max(-turn_radps, min(turn_radps, 1.8 * error))
    return Command(speed_mps * max(0.0, math.cos(error)) ** 2, turn)
