"""Eigenvalues of many symmetric 3x3 matrices at once."""

import numpy as np
from jaxtyping import Float, Float64

from navtool.pipeline.arrays import Array


def symmetric_eigenvalues(upper: Float[Array, "6 *batch"]) -> Float64[Array, "3 *batch"]:
    r"""The eigenvalues of symmetric 3x3 matrices in descending order, in closed form and float64.

    .. math::
        q = \tfrac{1}{3} \mathrm{tr} A, \quad p^2 = \tfrac{1}{6} \mathrm{tr} (A - q I)^2, \quad
        \varphi = \tfrac{1}{3} \arccos \frac{\det(A - q I)}{2 p^3}, \quad
        \lambda_{1, 3} = q + 2 p \cos(\varphi + \{0, \tfrac{2 \pi}{3}\}), \quad \lambda_2 = 3 q - \lambda_1 - \lambda_3

    Args:
        upper: The entries xx, xy, xz, yy, yz, zz of each matrix.

    Reference: O. K. Smith, "Eigenvalues of a symmetric 3 x 3 matrix", Communications of the ACM 4 (4), 1961.

    Note:
        The error is up to about 1e-8 of the largest entry where two eigenvalues nearly meet, elsewhere near 1e-15.
    """
    xx, xy, xz, yy, yz, zz = upper.astype(np.float64)
    q = (xx + yy + zz) / 3
    a, b, c = xx - q, yy - q, zz - q
    off = xy * xy + xz * xz + yz * yz
    p = np.sqrt((a * a + b * b + c * c + 2 * off) / 6)
    determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz)
    cube = p * p * p
    # Where p is 0 the matrix is q I, and any angle gives q three times.
    ratio = determinant / np.where(cube > 0, 2 * cube, 1.0)
    angle = np.arccos(np.clip(ratio, -1.0, 1.0)) / 3
    largest = q + 2 * p * np.cos(angle)
    smallest = q + 2 * p * np.cos(angle + 2 * np.pi / 3)
    return np.stack([largest, 3 * q - largest - smallest, smallest])
