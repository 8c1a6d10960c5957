"""The graph network against the same network from PyG's sparse layers, and what each choice switches."""

import importlib
from typing import Any

import pytest
import torch
from torch import Tensor
from torch.nn import functional

from navtool.pipeline.feature_graph import feature_graph, reliability_matrix
from navtool.train.graspe.agnn import Agnn

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")

SIZES = [4, 4, 2, 2]
NODES, BATCH = sum(SIZES), 3


@pytest.fixture
def geometric() -> Any:
    return importlib.import_module("torch_geometric.nn")


def small_net(**options: Any) -> Agnn:
    torch.manual_seed(0)
    return Agnn(NODES, 5, channels=6, dense_hidden=8, **options).eval()


def some_graphs() -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(1)
    f_vec, r = torch.rand(BATCH, NODES, generator=generator), torch.rand(BATCH, 2, generator=generator)
    return f_vec, feature_graph(f_vec, reliability_matrix(r[:, 0], r[:, 1], SIZES), 3.0)


@pytest.mark.parametrize("heads", [1, 2])
def test_equals_the_sparse_network(geometric: Any, heads: int) -> None:
    net = small_net(heads=heads)
    encode, attend, decode = (
        geometric.GCNConv(1, 6),
        geometric.GATConv(6, 6, heads=heads, edge_dim=1),
        geometric.GCNConv(6 * heads, 6),
    )
    encode.load_state_dict(net.encode.state_dict())
    attend.load_state_dict(net.attend.state_dict())
    decode.load_state_dict(net.decode.state_dict())
    f_vec, weights = some_graphs()
    edges = (~torch.eye(NODES, dtype=torch.bool)).nonzero().t()
    source, target = edges[0], edges[1]
    for sample in range(BATCH):
        weight = weights[sample, target, source]
        x = functional.relu(encode(f_vec[sample].unsqueeze(1), edges, weight))
        x = attend(x, edges, weight.unsqueeze(1))
        x = functional.relu(decode(x, edges, weight))
        expected = net.out(functional.relu(net.hidden(x.flatten()))).sigmoid()
        torch.testing.assert_close(net(f_vec, weights)[sample], expected, atol=1e-5, rtol=1e-5)


def test_probabilities_lie_in_the_open_unit_interval() -> None:
    probability = small_net()(*some_graphs())
    assert probability.shape == (BATCH, 5)
    assert bool(((probability > 0.0) & (probability < 1.0)).all())


def test_dropout_is_drawn_in_training_only() -> None:
    net, graphs = small_net(dropout=0.5), some_graphs()
    assert torch.equal(net(*graphs), net(*graphs))
    net.train()
    assert not torch.equal(net(*graphs), net(*graphs))


def test_first_channels_have_their_kinks_among_the_node_values() -> None:
    encode = Agnn().encode
    kinks = -encode.bias / encode.lin.weight[:, 0]
    assert bool(((kinks >= 0.0) & (kinks <= 1.0)).all())


@pytest.mark.parametrize("edge_attention", [True, False])
def test_scripted_equals_eager(*, edge_attention: bool) -> None:
    net = small_net(edge_attention=edge_attention, heads=2)
    torch.testing.assert_close(torch.jit.script(net)(*some_graphs()), net(*some_graphs()), atol=1e-6, rtol=1e-6)
