"""The wheeled robot's body, drives and limits."""

import math
from dataclasses import dataclass

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse

STEP_S = 0.01
"""Between two steps of the motion."""
GRAVITY_MPS2 = 9.81
BASE_HEIGHT_M = 0.165
"""Height of base_link, which lies in the middle between the four wheels' hubs, above the ground: the wheels' radius."""
WHEELS = ("front_left_wheel", "front_right_wheel", "rear_left_wheel", "rear_right_wheel")
"""The joints, in the order of all arrays."""


@dataclass(kw_only=True, slots=True)
class WheeledConfig:
    """A Husky A200.

    Published: length, width, mass, top speed and battery (24 V, 20 Ah, sealed lead acid) in its manual and data sheet;
    wheel base, track, the hubs' radius and the yaw inertia in its URDF; limits of acceleration and the widened track of
    its controllers (1.875 times the distance of the wheels, because skidding takes the rest) in their settings.
    What is chosen says so.
    """

    half_length_m: float = 0.495
    """Half the length of the footprint, bumpers included."""
    half_width_m: float = 0.335
    """Half the width of the footprint, wheels included."""
    wheel_base_m: float = 0.512
    """Between front and rear hubs."""
    track_m: float = 0.571
    """Between left and right wheels."""
    track_multiplier: float = 1.875
    """The wheels turn as if they were this much further apart: a skid-steered robot drags them sideways."""
    mass_kg: float = 50.0
    yaw_inertia_kgm2: float = 3.6
    centre_m: float = 0.2
    """Height of the centre of mass above the ground. Chosen."""
    speed_limit_mps: float = 1.0
    turn_limit_radps: float = 2.0
    acceleration_mps2: float = 3.0
    """How fast the drives' reference follows a command."""
    turn_acceleration_radps2: float = 6.0
    lag_s: float = 0.1
    """Time constant with which the wheels follow the reference. Chosen."""
    side_force_n: float = 125.0
    """The most with which the two wheels of a side push. Chosen: the drives stall before the tyres slip on firm ground,
    and a slope of 29 degrees is the steepest that it climbs."""
    efficiency: float = 0.75
    """Efficiency of motor and gear, without the windings. Chosen."""
    winding_loss_w_per_n2: float = 0.012
    """Heat in a side's windings for the square of its force. Chosen: a stalled side draws 190 W, and a turn on the spot
    on concrete takes about the drives' continuous 400 W."""
    idle_w: float = 60.0
    """Computers, sensors and drives at rest: the published eight hours of standby."""
    scrub_share: float = 0.4
    """Share of the full sliding friction that wheels dragged sideways at once resist with: they do not carry equally.
    Chosen."""
    scrub_angle: float = 0.2
    """Tangent of the slip angle at which half of it is reached. Chosen."""
    slip_stiffness: float = 20.0
    """Force over load and relative slip of a tyre that grips. Chosen: 5 % slip at a force as large as the load."""
    bounce_hz: float = 6.0
    """Natural frequency of the body on its tyres. Chosen."""
    bounce_damping: float = 0.25
    """Share of the critical one. Chosen."""
    fall_tilt_rad: float = 0.87
    """Roll or pitch from which on it tips over: its centre of mass leaves the wheels at 50-55 degrees."""

    def __post_init__(self) -> None:
        refuse(outside(self, 0, math.inf, *self.__slots__, above=True), outside(self, 0, 1, "efficiency"))
