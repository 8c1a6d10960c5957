"""Where a foot is for given joint angles, and the angles that put it there.

A leg's frame has its origin at the hip x axis and the body's axes: x forward, y left, z up.
"""

import math

import numpy as np
from jaxtyping import Float64

from navtool.pipeline.arrays import Array
from navtool.sim.legged.body import HIP_OFFSET_M, JOINT_HIGH_RAD, JOINT_LOW_RAD, KNEE_X_M, KNEE_Z_M, SHANK_M

_THIGH_M = math.hypot(KNEE_X_M, KNEE_Z_M)
_BEND_RAD = math.atan2(KNEE_X_M, -KNEE_Z_M)
"""By how much the knee lies ahead of the thigh's own axis."""
_LOW, _HIGH = JOINT_LOW_RAD[:3].tolist(), JOINT_HIGH_RAD[:3].tolist()
LONGEST_M = math.sqrt(
    _THIGH_M**2 + SHANK_M**2 + 2 * _THIGH_M * SHANK_M * math.cos(float(JOINT_HIGH_RAD[2]) + _BEND_RAD)
)
SHORTEST_M = math.sqrt(
    _THIGH_M**2 + SHANK_M**2 + 2 * _THIGH_M * SHANK_M * math.cos(float(JOINT_LOW_RAD[2]) + _BEND_RAD)
)
"""Distances of the foot from the hip y axis that the knee's range allows."""


def foot_in_leg(joint_rad: Float64[Array, "*legs 3"], side: Float64[Array, "*legs"]) -> Float64[Array, "*legs 3"]:
    """Return the foot's centre in the leg's frame for the angles of hip x, hip y and knee.

    Args:
        joint_rad: Angles by leg.
        side: +1 for a left leg, -1 for a right one.
    """
    roll, hip, knee = np.moveaxis(joint_rad, -1, 0)
    shank = hip + knee
    x = KNEE_X_M * np.cos(hip) + KNEE_Z_M * np.sin(hip) - SHANK_M * np.sin(shank)
    down = -KNEE_X_M * np.sin(hip) + KNEE_Z_M * np.cos(hip) - SHANK_M * np.cos(shank)
    out = HIP_OFFSET_M * side
    return np.stack([x, out * np.cos(roll) - down * np.sin(roll), out * np.sin(roll) + down * np.cos(roll)], axis=-1)


def foot_velocity_in_leg(
    joint_rad: Float64[Array, "*legs 3"], joint_radps: Float64[Array, "*legs 3"], side: Float64[Array, "*legs"]
) -> Float64[Array, "*legs 3"]:
    """Return the velocity in m/s of the foot's centre in the leg's frame: the derivative of `foot_in_leg`."""
    roll = joint_rad[..., 0]
    shank = joint_rad[..., 1] + joint_rad[..., 2]
    x, y, z = np.moveaxis(foot_in_leg(joint_rad, side), -1, 0)
    turn, swing, bend = np.moveaxis(joint_radps, -1, 0)
    down = z * np.cos(roll) - y * np.sin(roll)
    forward = down * swing - SHANK_M * np.cos(shank) * bend
    downward = -x * swing + SHANK_M * np.sin(shank) * bend
    return np.stack(
        [forward, -z * turn - np.sin(roll) * downward, y * turn + np.cos(roll) * downward],
        axis=-1,
    )


def joints_for_foot(x: float, y: float, z: float, side: float) -> tuple[float, float, float]:
    """Return hip x, hip y and knee angles in rad that put the foot at a point of the leg's frame.

    A point out of reach gives the angles of the nearest reach along the same line from the hip y axis, and a point
    less than the hip's offset from the hip x axis those of a point straight below; the angles always lie within the
    joints' ranges.
    """
    offset = HIP_OFFSET_M * side
    across = y * y + z * z - offset * offset
    down = -math.sqrt(across) if across > 1e-6 else -1e-3
    roll = math.atan2(z, y) - math.atan2(down, offset)
    if roll > math.pi:
        roll -= 2 * math.pi
    elif roll < -math.pi:
        roll += 2 * math.pi
    distance = math.hypot(x, down)
    reach = min(max(distance, SHORTEST_M), LONGEST_M)
    cosine = (reach * reach - _THIGH_M * _THIGH_M - SHANK_M * SHANK_M) / (2 * _THIGH_M * SHANK_M)
    bend = -math.acos(min(1.0, max(-1.0, cosine)))
    thigh = math.atan2(-x, -down) - math.atan2(SHANK_M * math.sin(bend), _THIGH_M + SHANK_M * math.cos(bend))
    return (
        min(max(roll, _LOW[0]), _HIGH[0]),
        min(max(thigh + _BEND_RAD, _LOW[1]), _HIGH[1]),
        min(max(bend - _BEND_RAD, _LOW[2]), _HIGH[2]),
    )
