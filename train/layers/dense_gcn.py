"""Graph convolution over batches of dense, weighted graphs."""

import torch
from torch import Tensor, nn


class DenseGCN(nn.Module):
    r"""Mix each node with its neighbours by the symmetrically normalised weights, after a linear map.

    .. math::
        X' = \hat D^{-1/2} \hat W \hat D^{-1/2} X \Theta + b, \qquad \hat W = W + I, \quad
        \hat D_{ii} = \sum_j \hat w_{ij}

    Reference: Kipf and Welling 2017, eq. (2).

    Guarantees:
        Equal to PyG's ``GCNConv`` on the graph of all off-diagonal pairs, parameter names included, so that either
        loads the other's state dict. The normalised matrix is never formed: memory is one [B, N, N] tensor, the input.

    Shape:
        x: [B, N, in_channels]; weights: [B, N, N] symmetric, non-negative, zero diagonal;
        result: [B, N, out_channels].
    """

    def __init__(self, in_channels: int, out_channels: int) -> None:
        super().__init__()
        self.lin = nn.Linear(in_channels, out_channels, bias=False)
        self.bias = nn.Parameter(torch.zeros(out_channels))
        nn.init.xavier_uniform_(self.lin.weight)

    def forward(self, x: Tensor, weights: Tensor) -> Tensor:
        """Return the new node features; the self loop of weight 1 is added here."""
        scale = (weights.sum(dim=2, keepdim=True) + 1.0).rsqrt()  # [B, N, 1], the degree is at least 1
        scaled = self.lin(x) * scale  # [B, N, out]
        mixed = torch.baddbmm(scaled, weights, scaled)  # (W + I) scaled
        return mixed * scale + self.bias
