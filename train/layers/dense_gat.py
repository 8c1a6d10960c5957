"""Graph attention over batches of dense graphs, with the edge weight as the edge's feature."""

from typing import Final

import torch
from torch import Tensor, nn
from torch.nn import functional


class DenseGAT(nn.Module):
    r"""Let each node attend to all nodes, itself included, by their features and the weight of the edge between them.

    .. math::
        e_{ij} = \operatorname{LeakyReLU}(a_d^\top \Theta x_i + a_s^\top \Theta x_j + a_e^\top \theta_e w_{ij}),
        \qquad
        x'_i = \sum_j \operatorname{softmax}_j(e_{ij}) \, \Theta x_j + b

    ============ ======================== ==============================================
    symbol       parameter                meaning
    ============ ======================== ==============================================
    Theta        ``lin.weight``           node map
    a_d, a_s     ``att_dst, att_src``     attention of the receiving and the sending node
    theta_e, a_e ``lin_edge, att_edge``   attention of the edge weight
    ============ ======================== ==============================================

    Reference: Velickovic et al. 2018, eq. (3) and (5).

    Guarantees:
        Equal to PyG's ``GATConv(edge_dim=1)`` on the graph of all off-diagonal pairs, parameter names included, so
        that either loads the other's state dict; without edge attention equal to ``GATConv`` without ``edge_dim``.

    Args:
        in_channels: Features per node.
        out_channels: Features per node and head.
        heads: Attention heads; their outputs are concatenated.
        edge_attention: Whether the weights enter the attention. If not, they are not looked at.
        self_loop_weight: Edge weight of each node's loop to itself; None takes the mean weight of the node's other
            edges, as PyG does by default.
        negative_slope: Of the LeakyReLU.

    Shape:
        x: [B, N, in_channels]; weights: [B, N, N] (row i receives, column j sends), its diagonal is not looked at;
        result: [B, N, heads * out_channels].

    Note:
        The graph is complete: an edge whose weight has underflowed to 0 stays a neighbour with edge feature 0.
    """

    edge_attention: Final[bool]

    def __init__(
        self,
        in_channels: int,
        out_channels: int,
        *,
        heads: int = 1,
        edge_attention: bool = True,
        self_loop_weight: float | None = None,
        negative_slope: float = 0.2,
    ) -> None:
        super().__init__()
        self.heads = heads
        self.out_channels = out_channels
        self.edge_attention = edge_attention
        self.self_loop_weight = self_loop_weight
        self.negative_slope = negative_slope
        self.lin = nn.Linear(in_channels, heads * out_channels, bias=False)
        self.att_src = nn.Parameter(torch.empty(1, heads, out_channels))
        self.att_dst = nn.Parameter(torch.empty(1, heads, out_channels))
        glorot = [self.lin.weight, self.att_src, self.att_dst]
        if edge_attention:
            self.lin_edge = nn.Linear(1, heads * out_channels, bias=False)
            self.att_edge = nn.Parameter(torch.empty(1, heads, out_channels))
            glorot += [self.lin_edge.weight, self.att_edge]
        self.bias = nn.Parameter(torch.zeros(heads * out_channels))
        for parameter in glorot:
            nn.init.xavier_uniform_(parameter)

    def forward(self, x: Tensor, weights: Tensor) -> Tensor:
        """Return the new node features."""
        batch, nodes = x.shape[0], x.shape[1]
        h: Tensor = self.lin(x)
        h = h.view(batch, nodes, self.heads, self.out_channels)  # [B, N, H, C]
        score_src = (h * self.att_src).sum(dim=3).transpose(1, 2)  # [B, H, N]
        score_dst = (h * self.att_dst).sum(dim=3).transpose(1, 2)
        scores = score_dst.unsqueeze(3) + score_src.unsqueeze(2)  # [B, H, N, N]
        if self.edge_attention:
            edge = (self.lin_edge.weight.view(1, self.heads, self.out_channels) * self.att_edge).sum(dim=2)  # [1, H]
            scores = torch.addcmul(scores, edge.view(1, self.heads, 1, 1), self._with_self_loops(weights).unsqueeze(1))
        attention = functional.leaky_relu(scores, self.negative_slope).softmax(dim=3)
        mixed = attention @ h.transpose(1, 2)  # [B, H, N, C]
        return mixed.transpose(1, 2).reshape(batch, nodes, self.heads * self.out_channels) + self.bias

    def _with_self_loops(self, weights: Tensor) -> Tensor:
        diagonal = weights.diagonal(0, 1, 2)  # [B, N]
        if self.self_loop_weight is None:
            loops = (weights.sum(dim=2) - diagonal) / max(weights.shape[2] - 1, 1)
        else:
            loops = torch.full_like(diagonal, self.self_loop_weight)
        return torch.diagonal_scatter(weights, loops, 0, 1, 2)
