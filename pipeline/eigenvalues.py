"""Eigenvalues of many symmetric 3x3 matrices at once."""

import numpy as np
from jaxtyping import Float, Float64

from navtool.pipeline.arrays import Array


def symmetric_eigenvalues(upper: Float[Array, " 6 *batch"]) -> Float64[Array, " 3 *batch"]:
    r"""The eigenvalues of symmetric 3x3 matrices in descending order, in closed form and float64.

    .. math::
        q = \tfrac{1}{3} \mathrm{tr} A, \quad p^2 = \tfrac{1}{6} \mathrm{tr} (A - q I)^2, \quad
        \varphi = \tfrac{1}{3} \arccos \tfrac{1}{2} \det \tfrac{1}{p} (A - q I), \quad
        \lambda_{1, 3} = q + 2 p \cos(\varphi + \{0, \tfrac{2 \pi}{3}\}), \quad \lambda_2 = 3 q - \lambda_1 - \lambda_3

    Args:
        upper: The entries xx, xy, xz, yy, yz, zz of each matrix.

    Reference: O. K. Smith, "Eigenvalues of a symmetric 3 x 3 matrix", Communications of the ACM 4 (4), 1961.

    Note:
        The error is up to about 1e-8 of the largest entry where two eigenvalues nearly meet, elsewhere near 1e-15;
        entries beyond 1e150 overflow, and below 1e-150 they count as 0.
    """
    xx, xy, xz, yy, yz, zz = upper.astype(np.float64)
    q = (xx + yy + zz) / 3
    off_diagonal = xy * xy + xz * xz + yz * yz
    p = np.sqrt(((xx - q) ** 2 + (yy - q) ** 2 + (zz - q) ** 2 + 2 * off_diagonal) / 6)
    # Where p is 0 the matrix is q I, and any angle gives q three times.
    scale = 1 / np.where(p > 0, p, 1.0)
    a, b, c, d, e, f = (xx - q) * scale, (yy - q) * scale, (zz - q) * scale, xy * scale, xz * scale, yz * scale
    determinant = a * (b * c - f * f) - d * (d * c - f * e) + e * (d * f - b * e)
    angle = np.arccos(np.clip(determinant / 2, -1.0, 1.0)) / 3
    largest = q + 2 * p * np.cos(angle)
    smallest = q + 2 * p * np.cos(angle + 2 * np.pi / 3)
    return np.stack([largest, 3 * q - largest - smallest, smallest])
