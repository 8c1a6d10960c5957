"""The dense graph network against PyG's sparse layers: forward and backward, equal weights, equal results."""

import torch
from _report import Row, median_seconds, write_report
from torch import Tensor, nn
from torch.nn import functional
from torch_geometric.nn import GATConv, GCNConv

from navtool.pipeline.feature_graph import FeatureGraphConfig, feature_graph, reliability_matrix
from navtool.train.graspe.agnn import Agnn

BATCH = 32
BAR = 20.0


class SparseAgnn(nn.Module):
    """The same network from PyG's layers, on one big graph of all samples, as PyG batches them."""

    def __init__(self, dense: Agnn, heads: int) -> None:
        super().__init__()
        self.encode = GCNConv(1, 16)
        self.attend = GATConv(16, 16, heads=heads, edge_dim=1)
        self.decode = GCNConv(16 * heads, 16)
        self.dropout = nn.Dropout(0.0)
        self.hidden = nn.Linear(dense.hidden.in_features, dense.hidden.out_features)
        self.out = nn.Linear(dense.out.in_features, dense.out.out_features)
        self.load_state_dict(dense.state_dict())

    def forward(self, f_vec: Tensor, edge_index: Tensor, edge_weight: Tensor) -> Tensor:
        """Return the probabilities, [B, T]."""
        x = functional.relu(self.encode(f_vec.reshape(-1, 1), edge_index, edge_weight))
        x = self.attend(x, edge_index, edge_weight.unsqueeze(1))
        x = functional.relu(self.decode(x, edge_index, edge_weight))
        x = functional.relu(self.hidden(x.view(f_vec.shape[0], -1)))
        probability: Tensor = self.out(x).sigmoid()
        return probability


def main() -> None:
    torch.manual_seed(0)
    config = FeatureGraphConfig()
    rows = [_compare(config, heads) for heads in (1, 4)]
    write_report("agnn", rows)


def _compare(config: FeatureGraphConfig, heads: int) -> Row:
    nodes = config.nodes()
    dense = Agnn(nodes, heads=heads, dropout=0.0)
    sparse = SparseAgnn(dense, heads)
    f_vec = torch.rand(BATCH, nodes)
    r = torch.rand(BATCH, 2)
    weights = feature_graph(f_vec, reliability_matrix(r[:, 0], r[:, 1], config.sizes()), config.edge_decay)
    batch, row, column = (~torch.eye(nodes, dtype=torch.bool)).expand(BATCH, -1, -1).nonzero(as_tuple=True)
    edge_index = torch.stack([batch * nodes + column, batch * nodes + row])
    edge_weight = weights[batch, row, column]

    dense_inputs = [f_vec.clone().requires_grad_(), weights.clone().requires_grad_()]
    sparse_inputs = [f_vec.clone().requires_grad_(), edge_weight.clone().requires_grad_()]

    def dense_step() -> Tensor:
        out: Tensor = dense(dense_inputs[0], dense_inputs[1])
        torch.autograd.backward(out.sum())
        return out.detach()

    def sparse_step() -> Tensor:
        out: Tensor = sparse(sparse_inputs[0], edge_index, sparse_inputs[1])
        torch.autograd.backward(out.sum())
        return out.detach()

    torch.testing.assert_close(dense_step(), sparse_step(), atol=1e-5, rtol=1e-5)
    ours, peer = median_seconds(dense_step, sparse_step, rounds=7)
    ratio = peer / ours
    return Row(
        what=f"forward + backward, batch {BATCH}, {nodes} nodes, {heads} head{'s' * (heads > 1)}",
        ours=ours * 1e3,
        peer=peer * 1e3,
        ratio=ratio,
        unit="ms",
        bar=BAR,
        holds=ratio >= BAR,
    )


if __name__ == "__main__":
    main()
