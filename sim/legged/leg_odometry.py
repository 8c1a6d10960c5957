"""Where the robot believes it went, from its joints, its gyroscope and the feet that stand."""

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.pipeline.geometry.transforms import quaternion_to_rpy
from navtool.sim.legged.body import FOOT_RADIUS_M, HIPS_M, SIDES
from navtool.sim.legged.leg_kinematics import foot_in_leg, foot_velocity_in_leg

_FULL_N = 60.0
"""A foot that presses this hard or harder counts fully."""
_LAG_S = 0.03
"""Time constant over which the velocity is smoothed."""


def leg_odometry(
    joint_rad: Float64[Array, "n 12"],
    joint_radps: Float64[Array, "n 12"],
    force_n: Float64[Array, "n 4"],
    rates_radps: Float64[Array, "n 3"],
    quaternion: Float64[Array, "n 4"],
    step_s: float,
) -> Float64[Array, "n 5"]:
    """Return x, y (m) and yaw (rad) since the start, forward speed (m/s) and turn (rad/s).

    A foot that stands is taken to be at rest, so the body moves as the foot moves under it, the other way round; feet
    count by how hard they press. That is wrong where a foot slips or sinks, and there the odometry drifts; so does
    the heading, which is the gyroscope's rate summed up.

    Args:
        joint_rad: Measured angles.
        joint_radps: Measured rates.
        force_n: How hard the feet press.
        rates_radps: Measured turn rates, body's axes, bias included.
        quaternion: Of the body (x, y, z, w); only roll and pitch are used, which gravity shows.
        step_s: Between two rows.
    """
    count = len(joint_rad)
    angles, rates = joint_rad.reshape(count, 4, 3), joint_radps.reshape(count, 4, 3)
    side = np.broadcast_to(SIDES, (count, 4))
    foot = HIPS_M + foot_in_leg(angles, side)
    moving = foot_velocity_in_leg(angles, rates, side) + np.cross(rates_radps[:, None, :], foot)
    # a round foot rolls: its centre moves on while the sole stands
    moving[..., 0] -= FOOT_RADIUS_M * (rates[..., 1] + rates[..., 2] + rates_radps[:, None, 1])
    weight = np.minimum(force_n / _FULL_N, 1.0) + 1e-6
    body = -(weight[..., None] * moving).sum(axis=1) / weight.sum(axis=1, keepdims=True)
    airborne = force_n.max(axis=1) < 1.0
    body[airborne] = 0.0
    roll, pitch, _ = np.moveaxis(quaternion_to_rpy(quaternion), -1, 0)
    level_x = np.cos(pitch) * body[:, 0] + np.sin(pitch) * (np.sin(roll) * body[:, 1] + np.cos(roll) * body[:, 2])
    level_y = np.cos(roll) * body[:, 1] - np.sin(roll) * body[:, 2]
    turn = (np.sin(roll) * rates_radps[:, 1] + np.cos(roll) * rates_radps[:, 2]) / np.cos(pitch)
    yaw = np.cumsum(turn) * step_s
    x = np.cumsum(np.cos(yaw) * level_x - np.sin(yaw) * level_y) * step_s
    y = np.cumsum(np.sin(yaw) * level_x + np.cos(yaw) * level_y) * step_s
    return np.stack([x, y, yaw, _smooth(level_x, step_s), _smooth(turn, step_s)], axis=-1)


def _smooth(values: Float64[Array, " n"], step_s: float) -> Float64[Array, " n"]:
    """Return the mean over the last moments."""
    span = max(1, round(2 * _LAG_S / step_s))
    padded = np.pad(values, (span - 1, 0), mode="edge")
    return np.asarray(np.convolve(padded, np.full(span, 1.0 / span), mode="valid"))
