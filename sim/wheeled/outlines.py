"""What is solid near the robot, and where its footprint is about to meet it."""

import math
from typing import NamedTuple

import numpy as np

from navtool.sim.world.obstacle import Obstacles

_BUCKET_M = 1.0


class Contact(NamedTuple):
    """A point of the footprint close to an outline, in the robot's axes."""

    gap_m: float
    """How far apart they are; below 0 where they overlap."""
    x_m: float
    """Where on the footprint."""
    y_m: float
    normal_x: float
    """Out of the outline, of unit length."""
    normal_y: float
    item: int
    """Number of the obstacle among all of the place."""


class Outlines:
    """The solid outlines of a place, against which a rectangular footprint is tested exactly.

    Args:
        obstacles: All that stands there; what yields is passed over.
        half_length_m: Of the footprint, along the robot's x.
        half_width_m: Of the footprint.
        half_side_m: Half the side of the square in which the robot moves.
    """

    def __init__(self, obstacles: Obstacles, half_length_m: float, half_width_m: float, half_side_m: float) -> None:
        self._half = half_length_m, half_width_m
        self._around_m = math.hypot(half_length_m, half_width_m)
        self._items = obstacles.items
        self._turns = [(math.cos(item.yaw_rad), math.sin(item.yaw_rad)) for item in obstacles.items]
        solid = np.array([not item.pliable for item in obstacles.items], bool)
        self._edge = math.ceil(half_side_m / _BUCKET_M) + 1
        middle = (np.arange(-self._edge, self._edge) + 0.5) * _BUCKET_M
        x, y = np.meshgrid(middle, middle)
        reach = self._around_m + 0.75 * _BUCKET_M
        near = (obstacles.distances(x, y) < reach) & solid[:, None, None]
        self._near: dict[tuple[int, int], tuple[int, ...]] = {}
        for number, row, column in np.argwhere(near).tolist():
            place = column - self._edge, row - self._edge
            self._near[place] = (*self._near.get(place, ()), number)

    def contacts(self, x_m: float, y_m: float, cos: float, sin: float, within_m: float) -> list[Contact]:
        """The points at which a robot there is closer than a distance to what is solid.

        Guarantee: if none is given for a distance of 0, footprint and outlines do not overlap, provided that the robot
        came there from the outside in steps shorter than 2 cm.
        """
        found: list[Contact] = []
        for number in self._near.get((math.floor(x_m / _BUCKET_M), math.floor(y_m / _BUCKET_M)), ()):
            item = self._items[number]
            away_x, away_y = item.x_m - x_m, item.y_m - y_m
            centre_x, centre_y = cos * away_x + sin * away_y, cos * away_y - sin * away_x
            if item.half_width_m is None:
                contact = self._point(centre_x, centre_y, item.half_length_m, number)
                if contact.gap_m < within_m:
                    found.append(contact)
            else:
                turn_cos, turn_sin = self._turns[number]
                axis_x, axis_y = cos * turn_cos + sin * turn_sin, cos * turn_sin - sin * turn_cos
                box = item.half_length_m, item.half_width_m
                aside = max(abs(axis_x * centre_x + axis_y * centre_y) - box[0], 0.0)
                beyond = max(abs(axis_x * centre_y - axis_y * centre_x) - box[1], 0.0)
                if math.hypot(aside, beyond) > self._around_m + within_m:
                    continue
                found += self._corners(centre_x, centre_y, axis_x, axis_y, box, number, within_m)
        return found

    def _point(self, x: float, y: float, radius: float, number: int) -> Contact:
        """The footprint against a round outline."""
        length, width = self._half
        near_x, near_y = min(max(x, -length), length), min(max(y, -width), width)
        away = math.hypot(x - near_x, y - near_y)
        if away > 1e-9:
            return Contact(away - radius, near_x, near_y, (near_x - x) / away, (near_y - y) / away, number)
        deep_x, deep_y = length - abs(x), width - abs(y)
        if deep_x < deep_y:
            return Contact(-deep_x - radius, math.copysign(length, x), y, -math.copysign(1.0, x), 0.0, number)
        return Contact(-deep_y - radius, x, math.copysign(width, y), 0.0, -math.copysign(1.0, y), number)

    def _corners(
        self, x: float, y: float, cos: float, sin: float, box: tuple[float, float], number: int, within: float
    ) -> list[Contact]:
        """Corners of a rectangle against the footprint, and corners of the footprint against the rectangle."""
        found = []
        for along, across in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            u, v = along * box[0], across * box[1]
            contact = self._point(x + cos * u - sin * v, y + sin * u + cos * v, 0.0, number)
            if contact.gap_m < within:
                found.append(contact)
            corner_x, corner_y = along * self._half[0], across * self._half[1]
            from_x, from_y = corner_x - x, corner_y - y
            u, v = cos * from_x + sin * from_y, cos * from_y - sin * from_x
            near_u, near_v = min(max(u, -box[0]), box[0]), min(max(v, -box[1]), box[1])
            away = math.hypot(u - near_u, v - near_v)
            if away >= within:
                continue
            if away > 1e-9:
                out_u, out_v, gap = (u - near_u) / away, (v - near_v) / away, away
            elif box[0] - abs(u) < box[1] - abs(v):
                out_u, out_v, gap = math.copysign(1.0, u), 0.0, abs(u) - box[0]
            else:
                out_u, out_v, gap = 0.0, math.copysign(1.0, v), abs(v) - box[1]
            found.append(Contact(gap, corner_x, corner_y, cos * out_u - sin * out_v, sin * out_u + cos * out_v, number))
        return found
