"""What a driver needs of a robot, whatever it walks or rolls on."""

from typing import NamedTuple, Protocol, runtime_checkable

from navtool.sim.drive.drive import Drive


class VehicleState(NamedTuple):
    """Where a robot is now and what is the matter with it. World frame, SI units."""

    time_s: float
    """Since the reset."""
    x_m: float
    y_m: float
    yaw_rad: float
    speed_mps: float
    """Forward."""
    turn_radps: float
    touches: str | None
    """What it pushes against, such as trunk or wall."""
    held: bool
    """Whether something soft takes most of its speed away."""
    fallen: bool
    """Whether it lies on the ground: it does not get up before the next reset."""


@runtime_checkable
class Vehicle(Protocol):
    """A robot in a place. The same calls after the same reset give the same drive, bit by bit."""

    speed_limit_mps: float
    turn_limit_radps: float
    half_width_m: float
    """Half the width of its footprint."""

    def reset(self, x_m: float, y_m: float, yaw_rad: float) -> VehicleState:
        """Stand at rest, and forget what happened before.

        Raises:
            SimError: It cannot stand there.
        """

    def step(self, speed_mps: float, turn_radps: float, duration_s: float, *, freed: bool = False) -> VehicleState:
        """The state after following a command for a while.

        Args:
            speed_mps: Forward speed; limited to the robot's.
            turn_radps: Turn, counter-clockwise; limited to the robot's.
            duration_s: A positive multiple of 0.02 s.
            freed: Whether the operator frees it: what is soft does not hold it meanwhile.
        """

    def drive(self, seed: int) -> Drive:
        """All that happened since the reset; the seed decides the errors of the robot's own sensors."""
