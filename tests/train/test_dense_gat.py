"""The dense graph attention is PyG's sparse one, with and without edges in the attention."""

import importlib
from typing import Any

import pytest
import torch
from torch import Tensor

from navtool.train.layers.dense_gat import DenseGAT

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")

BATCH, NODES, IN, OUT = 3, 7, 5, 4


@pytest.fixture
def geometric() -> Any:
    return importlib.import_module("torch_geometric.nn")


def random_graph() -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(0)
    x = torch.randn(BATCH, NODES, IN, generator=generator)
    weights = torch.rand(BATCH, NODES, NODES, generator=generator) * (1.0 - torch.eye(NODES))  # not even symmetric
    weights[0, 1, 2] = 0.0  # an underflowed edge is still an edge
    return x, weights


@pytest.mark.parametrize("heads", [1, 3])
@pytest.mark.parametrize(("self_loop", "fill_value"), [(None, "mean"), (1.0, 1.0), (0.0, 0.0)])
def test_equals_pyg_forward_and_gradients(
    geometric: Any, heads: int, self_loop: float | None, fill_value: str | float
) -> None:
    torch.manual_seed(0)
    sparse = geometric.GATConv(IN, OUT, heads=heads, edge_dim=1, fill_value=fill_value)
    torch.nn.init.normal_(sparse.bias)
    dense = DenseGAT(IN, OUT, heads=heads, self_loop_weight=self_loop)
    _compare(dense, sparse, uses_edges=True)


@pytest.mark.parametrize("heads", [1, 3])
def test_without_edge_attention_equals_pyg_without_edge_features(geometric: Any, heads: int) -> None:
    torch.manual_seed(0)
    sparse = geometric.GATConv(IN, OUT, heads=heads)
    dense = DenseGAT(IN, OUT, heads=heads, edge_attention=False)
    _compare(dense, sparse, uses_edges=False)
    x, weights = random_graph()
    assert torch.equal(dense(x, weights), dense(x, torch.zeros_like(weights)))


def test_edges_change_the_attention() -> None:
    torch.manual_seed(0)
    layer = DenseGAT(IN, OUT)
    x, weights = random_graph()
    assert not torch.allclose(layer(x, weights), layer(x, torch.zeros_like(weights)), atol=1e-3)


def test_the_diagonal_is_not_looked_at_and_inputs_stay_as_they_are() -> None:
    torch.manual_seed(0)
    layer = DenseGAT(IN, OUT)
    x, weights = random_graph()
    before = weights.clone()
    expected = layer(x, weights)
    assert torch.equal(weights, before)
    torch.testing.assert_close(layer(x, weights + 5.0 * torch.eye(NODES)), expected)


def test_renumbering_the_nodes_renumbers_the_result() -> None:
    torch.manual_seed(0)
    layer = DenseGAT(IN, OUT, heads=2)
    x, weights = random_graph()
    order = torch.randperm(NODES)
    renumbered = layer(x[:, order], weights[:, order][:, :, order])
    torch.testing.assert_close(renumbered, layer(x, weights)[:, order])


@pytest.mark.parametrize("edge_attention", [True, False])
@pytest.mark.parametrize("self_loop", [None, 1.0])
def test_scripted_equals_eager(*, edge_attention: bool, self_loop: float | None) -> None:
    torch.manual_seed(0)
    layer = DenseGAT(IN, OUT, heads=2, edge_attention=edge_attention, self_loop_weight=self_loop)
    torch.testing.assert_close(torch.jit.script(layer)(*random_graph()), layer(*random_graph()), atol=1e-6, rtol=1e-6)


def _compare(dense: DenseGAT, sparse: Any, *, uses_edges: bool) -> None:
    dense.load_state_dict(sparse.state_dict())
    x, weights = random_graph()
    x.requires_grad_()
    weights.requires_grad_()
    edges = (~torch.eye(NODES, dtype=torch.bool)).nonzero().t()
    source, target = edges[0], edges[1]
    expected = torch.stack([sparse(x[b], edges, weights[b, target, source, None]) for b in range(BATCH)])
    result = dense(x, weights)
    torch.testing.assert_close(result, expected, atol=1e-5, rtol=1e-5)
    mix = torch.randn(result.shape)
    names = [name for name, _ in dense.named_parameters()]
    inputs = [x, weights] if uses_edges else [x]
    ours = torch.autograd.grad((result * mix).sum(), [*inputs, *(dense.get_parameter(name) for name in names)])
    theirs = torch.autograd.grad((expected * mix).sum(), [*inputs, *(sparse.get_parameter(name) for name in names)])
    for own, other in zip(ours, theirs, strict=True):
        torch.testing.assert_close(own, other, atol=1e-5, rtol=1e-5)
