"""What a drive is to be: who drives, for how long, how fast, from where."""

from dataclasses import dataclass, field
from enum import StrEnum

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
        if not 1.0 <= self.duration_s <= 3600.0:
            raise ValueError(f"duration_s is {self.duration_s} s; a drive takes 1 to 3600 s")
        for name in ("careful", "mischief", "wander"):
            value: float = getattr(self, name)
            if not 0.0 <= value <= 1.0:
                raise ValueError(f"{name} is {value}; it is a share, 0 to 1")
        if len(self.speed_mps) != 2 or not 0.0 < self.speed_mps[0] <= self.speed_mps[1]:
            raise ValueError(f"speed_mps is {self.speed_mps}; give the least and the largest speed, above 0 m/s")
        if not self.turn_radps > 0.0:
            raise ValueError(f"turn_radps is {self.turn_radps}; give more than 0 rad/s")
        scripted = bool(self.orders or self.waypoints)
        if scripted is not (self.driver is DriverKind.script):
            what = "has neither orders nor waypoints" if not scripted else "has orders or waypoints"
            raise ValueError(f"a drive by driver {self.driver.value} {what}; only driver=script follows them")
