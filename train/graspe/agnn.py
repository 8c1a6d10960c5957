"""The attention-based graph network that turns the feature graph into success probabilities."""

from torch import Tensor, nn
from torch.nn import functional

from navtool.train.layers.dense_gat import DenseGAT
from navtool.train.layers.dense_gcn import DenseGCN


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

    def forward(self, f_vec: Tensor, weights: Tensor) -> Tensor:
        """Return the probability of success at each step."""
        x = functional.relu(self.encode(f_vec.unsqueeze(2), weights))  # [B, N, C]
        x = self.dropout(self.attend(x, weights))  # [B, N, heads * C]
        x = functional.relu(self.decode(x, weights))  # [B, N, C]
        x = functional.relu(self.hidden(x.flatten(1)))
        probability: Tensor = self.out(x).sigmoid()
        return probability
