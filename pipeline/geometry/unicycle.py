"""The motion of a robot that keeps its linear and angular velocity: circular arcs."""

import numpy as np
from jaxtyping import Float, Float64

from navtool.pipeline.arrays import Array


def rollout(velocity: Float[Array, "*batch 2"], steps: int, dt_s: float) -> Float64[Array, "*batch {steps} 3"]:
    r"""The poses after dt, 2 dt, ..., steps dt of a robot that starts at the origin, heading along x.

    .. math::
        x(t) = v t \, \mathrm{sinc}(\omega t / 2) \cos(\omega t / 2), \quad
        y(t) = v t \, \mathrm{sinc}(\omega t / 2) \sin(\omega t / 2), \quad
        \theta(t) = \omega t

    with sinc(a) = sin(a) / a: the chord of the arc and its direction. The form has no division by the angular
    velocity, so it is exact and smooth for straight motion too.

    Args:
        velocity: [v_mps, omega_radps], either of any sign.
        steps: Number of poses, at least 1.
        dt_s: Time between two poses, positive.

    Returns:
        [x_m, y_m, yaw_rad] of each pose; the yaw is not wrapped, so it counts whole turns.

    Raises:
        ValueError: `steps` or `dt_s` is not positive.

    Reference: GrASPE, IV-A: the trajectory extrapolated from the current velocity for the next T steps.
    """
    if steps < 1:
        raise ValueError(f"steps is {steps}; a roll-out needs at least 1")
    if not dt_s > 0:
        raise ValueError(f"dt_s is {dt_s} s; the time between two poses must be positive")
    return poses_after(velocity, dt_s * np.arange(1, steps + 1))


def poses_after(
    velocity: Float[Array, "*batch 2"], time_s: Float64[Array, " steps"]
) -> Float64[Array, "*batch steps 3"]:
    """The poses [x_m, y_m, yaw_rad] at the given times, of either sign, after the start; see `rollout`."""
    wide = velocity.astype(np.float64)
    distance = wide[..., 0, None] * time_s
    yaw = wide[..., 1, None] * time_s
    half = yaw / 2
    chord = distance * np.sinc(half / np.pi)
    return np.stack([chord * np.cos(half), chord * np.sin(half), yaw], axis=-1)
