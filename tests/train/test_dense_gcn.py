"""The dense graph convolution is PyG's sparse one, and a scripted one is the eager one."""

import importlib
from typing import Any

import pytest
import torch
from torch import Tensor

from navtool.train.layers.dense_gcn import DenseGCN

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")

BATCH, NODES = 3, 7


@pytest.fixture
def sparse() -> Any:
    return importlib.import_module("torch_geometric.nn").GCNConv(5, 4)


def random_graph() -> tuple[Tensor, Tensor]:
    generator = torch.Generator().manual_seed(0)
    x = torch.randn(BATCH, NODES, 5, generator=generator)
    weights = torch.rand(BATCH, NODES, NODES, generator=generator)
    return x, (weights + weights.transpose(1, 2)) * (1.0 - torch.eye(NODES))


def test_equals_pyg_forward_and_gradients(sparse: Any) -> None:
    torch.manual_seed(0)
    torch.nn.init.normal_(sparse.bias)
    dense = DenseGCN(5, 4)
    dense.load_state_dict(sparse.state_dict())
    x, weights = random_graph()
    x.requires_grad_()
    weights.requires_grad_()
    mix = torch.randn(BATCH, NODES, 4)
    edges = (~torch.eye(NODES, dtype=torch.bool)).nonzero().t()
    source, target = edges[0], edges[1]
    expected = torch.stack([sparse(x[b], edges, weights[b, target, source]) for b in range(BATCH)])
    result = dense(x, weights)
    torch.testing.assert_close(result, expected, atol=1e-5, rtol=1e-5)
    ours = torch.autograd.grad((result * mix).sum(), [x, weights, dense.lin.weight, dense.bias])
    theirs = torch.autograd.grad((expected * mix).sum(), [x, weights, sparse.lin.weight, sparse.bias])
    off_diagonal = 1.0 - torch.eye(NODES)
    for index, (own, other) in enumerate(zip(ours, theirs, strict=True)):
        mask = off_diagonal if index == 1 else torch.ones(())  # PyG never sees the diagonal
        torch.testing.assert_close(own * mask, other * mask, atol=1e-5, rtol=1e-5)


def test_a_node_without_neighbours_keeps_to_itself() -> None:
    torch.manual_seed(0)
    layer = DenseGCN(5, 4)
    x, _ = random_graph()
    torch.testing.assert_close(layer(x, torch.zeros(BATCH, NODES, NODES)), layer.lin(x) + layer.bias)


def test_renumbering_the_nodes_renumbers_the_result() -> None:
    torch.manual_seed(0)
    layer = DenseGCN(5, 4)
    x, weights = random_graph()
    order = torch.randperm(NODES)
    renumbered = layer(x[:, order], weights[:, order][:, :, order])
    torch.testing.assert_close(renumbered, layer(x, weights)[:, order])


def test_scripted_equals_eager() -> None:
    torch.manual_seed(0)
    layer = DenseGCN(5, 4)
    torch.testing.assert_close(torch.jit.script(layer)(*random_graph()), layer(*random_graph()), atol=1e-6, rtol=1e-6)
