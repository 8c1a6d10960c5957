"""GrASPE's reliability-aware feature graph: encoded sensor features become nodes, their likeness becomes edges.

Plain tensor functions that both the eager and the scripted network call.

Reference:
    GrASPE, section IV-D, eq. (6) and (7); Lemma 1 (symmetric, zero diagonal, non-negative) and Lemma 2 (the
    Laplacian is positive semi-definite) hold for every output of `feature_graph`.
"""

import math
from dataclasses import dataclass

import torch
from torch import Tensor

from navtool.base.setting_checks import outside
from navtool.base.setting_error import refuse
from navtool.pipeline.scripting import no_type_check


@dataclass(kw_only=True, slots=True)
class FeatureGraphConfig:
    """How many nodes each encoder contributes, and how fast edges fade with the distance of two features."""

    image: int = 40
    """Nodes of the image encoder, at least 1."""
    point: int = 40
    """Nodes of the point cloud encoder, at least 1."""
    velocity: int = 20
    """Nodes of the velocity history encoder, at least 1."""
    trajectory: int = 20
    """Nodes of the trajectory image encoder, at least 1."""
    edge_decay: float = 15.0
    """Lambda of eq. (6), dimensionless, in (0, 40]: beyond that the weakest edge, exp(-2 lambda), is 0 in float32."""

    def __post_init__(self) -> None:
        """Refuse sizes and decays that make no graph."""
        refuse(
            outside(self, 1, math.inf, "image", "point", "velocity", "trajectory", unit="nodes"),
            outside(self, 0, 40, "edge_decay", above=True, cure="the paper uses 15"),
        )

    def sizes(self) -> list[int]:
        """Return the nodes per encoder in the order of the feature vector: image, point, velocity, trajectory."""
        return [self.image, self.point, self.velocity, self.trajectory]

    def nodes(self) -> int:
        """Return the number of graph nodes N."""
        return self.image + self.point + self.velocity + self.trajectory


@no_type_check
def reliability_matrix(r_image: Tensor, r_point: Tensor, sizes: list[int]) -> Tensor:
    r"""Return how far each pair of nodes may be trusted.

    .. math::
        r_{ij} = \begin{cases}
            r_{img}                          & \text{one is an image node, the other no point node} \\
            r_{point}                        & \text{one is a point node, the other no image node} \\
            \tfrac{1}{2}(r_{img} + r_{point}) & \text{one is an image node, the other a point node} \\
            1                                & \text{otherwise}
        \end{cases}

    Reference: GrASPE, eq. (7).

    Args:
        r_image: Image reliability in [0, 1].
        r_point: Point cloud reliability in [0, 1].
        sizes: Nodes of [image, point, and any further encoders] in the order of the feature vector.

    Shape:
        r_image, r_point: [B]; result: [B, N, N] float32 with N = sum(sizes).

    Note:
        The set notation of eq. (7) leaves pairs open; the reading above is the symmetric one that Lemma 1 needs.
    """
    nodes = sum(sizes)
    is_image = torch.zeros(nodes, device=r_image.device)
    is_image[: sizes[0]] = 1.0
    is_point = torch.zeros(nodes, device=r_image.device)
    is_point[sizes[0] : sizes[0] + sizes[1]] = 1.0
    # r is linear in the two reliabilities; the coefficients are 0, 1/2 or 1.
    image_pair = torch.maximum(is_image.unsqueeze(1), is_image)  # [N, N]
    point_pair = torch.maximum(is_point.unsqueeze(1), is_point)
    both = image_pair * point_pair
    from_image = image_pair - 0.5 * both
    from_point = point_pair - 0.5 * both
    rest = 1.0 - from_image - from_point
    r_image = r_image.float().view(-1, 1, 1)
    r_point = r_point.float().view(-1, 1, 1)
    return torch.addcmul(torch.addcmul(rest, from_image, r_image), from_point, r_point)  # [B, N, N], eq. (7)


@no_type_check
def feature_graph(f_vec: Tensor, reliability: Tensor, edge_decay: float = 15.0) -> Tensor:
    r"""Return the weighted adjacency matrix of the feature vector.

    .. math::
        w_{ij} = \exp(-\lambda \, |f_i - f_j| \, (2 - r_{ij})) \quad (i \ne j), \qquad w_{ii} = 0

    =========== ==============================================
    symbol      argument
    =========== ==============================================
    f           ``f_vec``, node values in [0, 1]
    r           ``reliability``, of `reliability_matrix`
    lambda      ``edge_decay``, dimensionless
    =========== ==============================================

    Reference: GrASPE, eq. (6).

    Shape:
        f_vec: [..., N]; reliability: [..., N, N], its leading dimensions broadcast against those of f_vec;
        result: [..., N, N] float32, whatever the input's type.

    Note:
        The proof of Lemma 1 has r in place of (2 - r); eq. (6) holds here: lower reliability, weaker edges.
    """
    f_vec = f_vec.float()  # bfloat16 features would move the exponent by up to 0.06
    distance = (f_vec.unsqueeze(-1) - f_vec.unsqueeze(-2)).abs()  # [..., N, N]
    weights = torch.exp(distance * ((reliability.float() - 2.0) * edge_decay))  # eq. (6)
    # The distance of a node from itself is exactly 0, so its weight is exactly 1 before the identity is taken off.
    return weights - torch.eye(f_vec.shape[-1], device=f_vec.device)
