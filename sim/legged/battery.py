"""What the robot draws from its battery: electronics, the motors' work, and their losses."""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.arrays import Array


@dataclass(kw_only=True, slots=True)
class BatteryConfig:
    """Constants of Spot's battery and drives.

    Published (Spot SDK documentation, "About Spot"): 605 Wh, at most 58.8 V, typically 90 minutes of work (403 W) or
    180 minutes of standby (202 W). The rest follows or is chosen, as each field says.
    """

    idle_w: float = 202.0
    """Computers, sensors and drives at rest: the published standby."""
    loss_w_per_n2m2: float = 0.035
    """Heat in the windings for the square of a joint's torque. Chosen so that a trot at 0.6 m/s on concrete draws
    about the published typical power."""
    regenerated: float = 0.0
    """Share of braking work that flows back into the battery, 0-1; the rest becomes heat. Not published."""
    full_v: float = 58.8
    """At no load when fully charged: 14 lithium-ion cells in series."""
    empty_v: float = 46.2
    """At no load when all of the energy is drawn: 3.3 V a cell. Chosen."""
    energy_wh: float = 605.0
    """Energy of a full battery."""
    resistance_ohm: float = 0.08
    """By which the voltage sags under load. Chosen."""

    def __post_init__(self) -> None:
        refuse(
            outside(self, 0, 1, "regenerated", cure="give a share"),
            outside(self, 0, math.inf, "idle_w", "loss_w_per_n2m2"),
            outside(self, 0, math.inf, "energy_wh", "resistance_ohm", above=True),
        )


def drawn_power(
    torque_nm: Float64[Array, "n joints"], rate_radps: Float64[Array, "n joints"], config: BatteryConfig
) -> Float64[Array, " n"]:
    """Return the power in W that the battery gives at each moment.

    Each motor draws what it puts into its joint; what a joint puts into its motor is lost but for the regenerated
    share: one motor does not feed another, so the work drawn is never less than the work done.
    """
    work = torque_nm * rate_radps
    losses = config.loss_w_per_n2m2 * (torque_nm * torque_nm).sum(axis=1)
    given, taken = np.maximum(work, 0.0).sum(axis=1), np.maximum(-work, 0.0).sum(axis=1)
    return np.asarray(config.idle_w + losses + given - config.regenerated * taken)


def current_and_voltage(
    power_w: Float64[Array, " n"], step_s: float, config: BatteryConfig
) -> tuple[Float64[Array, " n"], Float64[Array, " n"]]:
    """Return current in A (above 0 while discharging) and voltage in V that give a power, from a full battery on."""
    drawn_wh = np.cumsum(power_w) * step_s / 3600.0
    open_v = config.full_v - (config.full_v - config.empty_v) * np.minimum(drawn_wh / config.energy_wh, 1.0)
    root = np.sqrt(np.maximum(open_v * open_v - 4.0 * config.resistance_ohm * power_w, 0.0))
    current = (open_v - root) / (2.0 * config.resistance_ohm)
    return current, open_v - config.resistance_ohm * current
