"""The attention-based graph network that turns the feature graph into success probabilities."""

import torch
from torch import Tensor, nn
from torch.nn import functional

from navtool.train.layers.dense_gat import DenseGAT
from navtool.train.layers.dense_gcn import DenseGCN
from navtool.train.layers.first_weights import spread_relu, spread_sigmoid


class Agnn(nn.Module):
    """Success probabilities from node values and the weights between them: GCN, GAT, GCN, two dense layers.

    Reference: GrASPE, section IV-E and fig. 3.

    Args:
        nodes: Graph nodes N.
        horizon: Predicted steps T.
        channels: Channels of each graph layer, and of each attention head.
        heads: Attention heads.
        edge_attention: Whether the weights enter the attention.
        self_loop_weight: Of the attention's self loops; None takes the mean of the other edges.
        dense_hidden: Units between the dense layers.
        dropout: After the attention.

    Shape:
        f_vec: [B, N]; weights: [B, N, N] of `feature_graph`; result: [B, T] in (0, 1).

    Note:
        Node values lie in (0, 1): with PyG's zero bias the first layer would start linear, half of its channels dead
        behind the ReLU. Its first biases put the kinks of its channels between 0 and 1 instead, and all first weights
        have ReLU's gain.
    """

    def __init__(
        self,
        nodes: int = 120,
        horizon: int = 10,
        *,
        channels: int = 16,
        heads: int = 1,
        edge_attention: bool = True,
        self_loop_weight: float | None = None,
        dense_hidden: int = 128,
        dropout: float = 0.5,
    ) -> None:
        super().__init__()
        self.encode = DenseGCN(1, channels)
        self.attend = DenseGAT(
            channels, channels, heads=heads, edge_attention=edge_attention, self_loop_weight=self_loop_weight
        )
        self.dropout = nn.Dropout(dropout)
        self.decode = DenseGCN(channels * heads, channels)
        self.hidden = nn.Linear(nodes * channels, dense_hidden)
        self.out = nn.Linear(dense_hidden, horizon)
        self._spread_first_weights()

    def forward(self, f_vec: Tensor, weights: Tensor) -> Tensor:
        """Return the probability of success at each step."""
        x = functional.relu(self.encode(f_vec.unsqueeze(2), weights))  # [B, N, C]
        x = self.dropout(self.attend(x, weights))  # [B, N, heads * C]
        x = functional.relu(self.decode(x, weights))  # [B, N, C]
        x = functional.relu(self.hidden(x.flatten(1)))
        probability: Tensor = self.out(x).sigmoid()
        return probability

    def _spread_first_weights(self) -> None:
        for layer in (self.encode.lin, self.attend.lin, self.decode.lin, self.hidden):
            spread_relu(layer)
        spread_sigmoid(self.out)
        with torch.no_grad():
            kinks = torch.rand_like(self.encode.bias)
            self.encode.bias.copy_(-kinks * self.encode.lin.weight[:, 0])
