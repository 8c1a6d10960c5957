"""What stands in the robot's way: solid boxes, upright cylinders and balls."""

from dataclasses import dataclass
from enum import Enum

from navtool.sim.errors import SimError


class Form(Enum):
    """The form of an obstacle, and what its `size_m` holds."""

    BOX = "box"
    """Half lengths along its own x, y and z."""
    CYLINDER = "cylinder"
    """Radius, half height, and a third number that is not read."""
    BALL = "sphere"
    """Radius, and two numbers that are not read."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Obstacle:
    """A solid body that stands still."""

    name: str
    """What a collision with it is reported as, such as tree or wall."""
    form: Form
    centre_m: tuple[float, float, float]
    """World frame."""
    size_m: tuple[float, float, float]
    """As the form says; what is read must be above 0."""
    yaw_rad: float = 0.0

    def __post_init__(self) -> None:
        read = {Form.BOX: 3, Form.CYLINDER: 2, Form.BALL: 1}[self.form]
        if min(self.size_m[:read]) <= 0:
            what = f"obstacle {self.name} has size {self.size_m}"
            raise SimError(what, cure=f"the first {read} of them are half lengths in metres, above 0")


def obstacle_xml(number: int, obstacle: Obstacle) -> str:
    """Return the obstacle as a geom named obstacle_NUMBER."""
    x, y, z = obstacle.centre_m
    size = " ".join(str(length) for length in obstacle.size_m)
    return (
        f'<geom name="obstacle_{number}" type="{obstacle.form.value}" size="{size}" pos="{x} {y} {z}"'
        f' euler="0 0 {obstacle.yaw_rad}" contype="1" conaffinity="0" friction="0.6"/>'
    )
