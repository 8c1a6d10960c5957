"""What a drive is to be: who drives, for how long, how fast, from where."""

import math
from dataclasses import dataclass, field
from enum import StrEnum

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import refuse
from navtool.sim.drive.script import Order, Waypoint


class DriverKind(StrEnum):
    """Who drives."""

    random = "random"
    """A randomised driver who gets into trouble now and then."""
    script = "script"
    """The script's orders, then its waypoints."""
    course = "course"
    """A careful driver on a way from the place's start to its goal."""


@dataclass(kw_only=True, slots=True)
class PoseConfig:
    """Where a drive starts."""

    x_m: float = 0.0
    """World frame."""
    y_m: float = 0.0
    yaw_rad: float = 0.0
    """Heading, counter-clockwise from the world's x."""


@dataclass(kw_only=True, slots=True)
class DriveConfig:
    """One drive in a place."""

    driver: DriverKind = DriverKind.random
    """Who drives."""
    duration_s: float = 60.0
    """The longest that it takes, 1 to 3600 s; a script or a course that is done ends earlier."""
    careful: float = 0.25
    """Share of random drives without any careless leg, 0 to 1: they are mostly successes."""
    mischief: float = 0.3
    """Share of the other drives' legs that lead carelessly into what stands or grows there, 0 to 1."""
    wander: float = 0.3
    """Share of a random driver's legs that hold a random speed and turn instead of going to a point, 0 to 1."""
    speed_mps: list[float] = field(default_factory=lambda: [0.4, 0.9])
    """Least and largest speed of a leg, above 0; limited to the robot's. Along waypoints and a course it is their
    mean."""
    turn_radps: float = 0.8
    """Largest turn that a driver asks for, above 0; limited to the robot's."""
    orders: list[Order] = field(default_factory=list)
    """A script's orders."""
    waypoints: list[Waypoint] = field(default_factory=list)
    """A script's points to go through, after its orders."""
    start: PoseConfig | None = None
    """Where it starts; None is anywhere free for the random driver, and the place's start for the others."""

    def __post_init__(self) -> None:
        rising = len(self.speed_mps) == 2 and 0.0 < self.speed_mps[0] <= self.speed_mps[1]
        scripted = bool(self.orders or self.waypoints)
        has = "has orders or waypoints" if scripted else "has neither orders nor waypoints"
        refuse(
            outside(self, 1, 3600, "duration_s", unit="s"),
            outside(self, 0, 1, "careful", "mischief", "wander", cure="give a share"),
            fault(
                "speed_mps",
                f"{self.speed_mps} is not the least and the largest speed in m/s",
                "give two that rise, above 0",
                when=not rising,
            ),
            outside(self, 0, math.inf, "turn_radps", unit="rad/s", above=True),
            fault(
                "driver",
                f"a drive by driver {self.driver.value} {has}",
                "only driver=script follows them",
                when=scripted is not (self.driver is DriverKind.script),
            ),
        )
