"""What a driver asks of a robot."""

from typing import NamedTuple, Protocol, runtime_checkable

from navtool.sim.drive.vehicle import VehicleState

DECIDE_S = 0.1
"""Between two decisions of a driver."""


class Command(NamedTuple):
    """What is asked for until the next decision."""

    speed_mps: float
    turn_radps: float
    freed: bool = False
    """Whether the operator frees the robot."""


@runtime_checkable
class Driver(Protocol):
    """Who decides."""

    def command(self, state: VehicleState) -> Command | None:
        """What is asked for now; None ends the drive."""
