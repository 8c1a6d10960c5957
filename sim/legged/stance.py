"""How the standing feet share the force and torque that the body needs."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64
from scipy.linalg.lapack import dposv

from navtool.pipeline.arrays import Array

LEAST_N, MOST_N = 8.0, 450.0
"""Bounds of what a standing foot presses with."""
_WEIGHTS = np.array([1.0, 1.0, 1.5, 14.0, 14.0, 8.0])
"""Price of an error in each component of the wrench: newtons along x, y, z and newton metres about the body's axes."""
_EFFORT = 0.15
"""Price of a newton metre at a joint, against newtons of the wrench."""
_FORCE_EFFORT = np.diag([1e-3, 1e-3, 2e-4])
"""Price of a newton across and along the vertical: feet that push against each other slip on smooth ground."""
_LEAST_TRUST = 0.05
_NEVER = 1e12
"""Price at which a foot carries nothing."""
_LEG, _AXIS = np.arange(4)[:, None, None], np.arange(3)[None, :, None]
_JOINT = 6 + 3 * _LEG + np.arange(3)[None, None, :]
_BLOCKS = 12 * (3 * _LEG + _AXIS) + 3 * _LEG + np.arange(3)[None, None, :]
"""Where each leg's 3 x 3 block lies in the flat 12 x 12 matrix."""
_DIAGONAL = [(np.arange(3 * leg, 3 * leg + 3),) * 2 for leg in range(4)]


def ground_forces(
    jacobian: Float64[Array, "12 18"], wrench: Float64[Array, "6"], trust: Sequence[float], friction: float
) -> Float64[Array, "12"]:
    """Return the force in N, in world axes, that the ground shall exert on each foot: x, y, z by leg.

    The weighted least squares solution for the wrench with a price on the torque that each force costs the leg's
    joints, the higher the less a foot is trusted: it takes up its load, and passes it on before it is lifted, without
    a jerk, and a foot that stands far from its hip carries less. A foot that would have to pull gets the least
    pressure instead and the others share the rest; at last each force is drawn into its friction cone. Feet that are
    not trusted at all get none.

    Args:
        jacobian: Of the feet: rows x, y, z by leg, columns the body's six velocities and the joints'.
        wrench: The force (world axes) and torque (body's axes) wanted.
        trust: How much each foot may carry, 0 (it is in the air) to 1.
        friction: Coulomb's coefficient that is counted on; above 0.
    """
    standing = [leg for leg in range(4) if trust[leg] > 0.0]
    wrench_of_forces = jacobian[:, :6]
    weighted = wrench_of_forces * _WEIGHTS
    arms = jacobian.reshape(4, 3, -1)[_LEG, _AXIS, _JOINT]
    arms *= np.array([[[_EFFORT / max(share, _LEAST_TRUST)]] for share in trust])
    normal = weighted @ wrench_of_forces.T
    normal.reshape(-1)[_BLOCKS] += arms @ arms.swapaxes(1, 2) + _FORCE_EFFORT
    left = set(range(4)) - set(standing)
    given = [0.0] * 4
    while True:
        for leg in left:
            normal[_DIAGONAL[leg]] = _NEVER
        rest = wrench - np.array([given[0], given[1], given[2], given[3]]) @ wrench_of_forces[2::3]
        _, solution, _ = dposv(normal, weighted @ rest)
        rows = solution.reshape(4, 3).tolist()
        carrying = [leg for leg in standing if leg not in left]
        pulling = [leg for leg in carrying if rows[leg][2] < LEAST_N]
        if not pulling or len(pulling) == len(carrying):
            break
        for leg in pulling:
            given[leg] = LEAST_N
            left.add(leg)
    for leg in range(4):
        if given[leg] > 0.0 or trust[leg] == 0.0:
            rows[leg] = [0.0, 0.0, given[leg]]
    for leg in standing:
        x, y, z = rows[leg]
        z = min(max(z, LEAST_N), MOST_N)
        across = (x * x + y * y) ** 0.5
        share = friction * z / across if across > friction * z else 1.0
        rows[leg] = [x * share, y * share, z]
    return np.array(rows).reshape(-1)
