"""Settings of the walking controller."""

import math
from dataclasses import dataclass

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse

CONTROL_S = 0.004
"""Between two decisions of the controller."""


@dataclass(kw_only=True, slots=True)
class ControllerConfig:
    """Gains and limits; chosen so that the robot walks on level hard ground, the same for every terrain."""

    height_m: float = 0.50
    """Height of the hips above the ground; 0.3 to 0.6."""
    acceleration_mps2: float = 1.2
    """How fast the speed follows a command; above 0."""
    turn_acceleration_radps2: float = 2.0
    """How fast the turn follows a command; above 0."""
    top_turn_radps: float = 0.8
    """Commands are limited to this; above 0."""
    speed_gain_hz: float = 6.0
    """Acceleration for an error in speed; 0 or more."""
    speed_integral_hz2: float = 2.0
    """Acceleration for an error in speed that lasts, as in plants or uphill; 0 or more."""
    height_gains: tuple[float, float] = (120.0, 18.0)
    """Acceleration for an error in height (1/s2) and in its rate (1/s)."""
    tilt_gains: tuple[float, float] = (200.0, 22.0)
    """Angular acceleration for an error in roll and pitch (1/s2) and in their rates (1/s)."""
    yaw_gains: tuple[float, float] = (60.0, 14.0)
    """The same for yaw."""
    sway_gains: tuple[float, float] = (16.0, 6.0)
    """Sideways acceleration for an error in place (1/s2) and in speed (1/s)."""
    placement_gain_s: float = 0.12
    """How far ahead a foot is put for an error in speed; 0 or more."""
    touch_n: float = 12.0
    """A foot that presses harder than this stands on something; above 0."""
    reach_mps: float = 0.5
    """How fast a foot goes on down when the ground is not where it was expected; above 0."""
    push_mps: float = 0.25
    """A standing robot that is pushed to this speed begins to step; above 0."""

    def __post_init__(self) -> None:
        above = ("acceleration_mps2", "turn_acceleration_radps2", "top_turn_radps", "touch_n", "reach_mps", "push_mps")
        refuse(
            outside(self, 0.3, 0.6, "height_m", unit="m", cure="the legs are 0.65 m long"),
            outside(self, 0, math.inf, *above, above=True),
        )
