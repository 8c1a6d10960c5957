"""The folded point layer is Linear + BatchNorm1d + ReLU (+ maximum), without their memory."""

import pytest
import torch
from torch import Tensor, nn

from navtool.train.layers.point_linear import PointLinear

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")

IN, OUT = 6, 40


def layer_and_oracle() -> tuple[PointLinear, nn.Sequential]:
    torch.manual_seed(0)
    layer = PointLinear(IN, OUT)
    nn.init.normal_(layer.gamma)  # negative scales too: they turn minima into maxima
    nn.init.normal_(layer.beta)
    linear, norm = nn.Linear(IN, OUT, bias=False).double(), nn.BatchNorm1d(OUT).double()
    with torch.no_grad():
        linear.weight.copy_(layer.weight)
        norm.weight.copy_(layer.gamma)
        norm.bias.copy_(layer.beta)
    return layer, nn.Sequential(linear, norm, nn.ReLU())


def some_points(count: int) -> Tensor:
    generator = torch.Generator().manual_seed(1)
    return torch.randn(count, IN, generator=generator) * torch.tensor([9.0, 3.0, 1.0, 0.5, 0.1, 0.01]) + 2.0


def oracle_max(oracle: nn.Sequential, x: Tensor, counts: list[int]) -> Tensor:
    mapped = oracle(x)
    empty = torch.zeros(OUT, dtype=x.dtype)
    return torch.stack([part.amax(dim=0) if len(part) else empty for part in torch.split(mapped, counts)])


def test_equals_batch_norm_in_values_gradients_and_running_statistics() -> None:
    layer, oracle = layer_and_oracle()
    ours, theirs = some_points(500).requires_grad_(), some_points(500).double().requires_grad_()
    for _ in range(3):
        result, expected = layer(ours), oracle(theirs)
    torch.testing.assert_close(result, expected.float(), atol=1e-4, rtol=1e-4)
    torch.testing.assert_close(layer.running_mean, oracle[1].running_mean.float(), atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(layer.running_var, oracle[1].running_var.float(), atol=1e-5, rtol=1e-4)
    mix = torch.randn(500, OUT)
    own = torch.autograd.grad((result * mix).sum(), [ours, layer.weight, layer.gamma, layer.beta])
    other = torch.autograd.grad((expected * mix).sum(), [theirs, *oracle.parameters()])
    for a, b in zip(own, other, strict=True):
        torch.testing.assert_close(a, b.float(), atol=1e-4 * b.abs().max().item(), rtol=1e-3)


@pytest.mark.parametrize("counts", [[500], [1, 16, 0, 483], [3000, 17]])
def test_maximum_equals_that_of_the_kept_features_with_gradients(counts: list[int]) -> None:
    layer, oracle = layer_and_oracle()
    x = some_points(sum(counts))
    ours, theirs = x.clone().requires_grad_(), x.double().requires_grad_()
    result, expected = layer.max_over_points(ours, counts), oracle_max(oracle, theirs, counts)
    torch.testing.assert_close(result, expected.float(), atol=1e-4, rtol=1e-4)
    mix = torch.randn(len(counts), OUT)
    own = torch.autograd.grad((result * mix).sum(), [ours, layer.weight, layer.gamma, layer.beta])
    other = torch.autograd.grad((expected * mix).sum(), [theirs, *oracle.parameters()])
    for a, b in zip(own, other, strict=True):
        torch.testing.assert_close(a, b.float(), atol=1e-4 * b.abs().max().item(), rtol=1e-3)


@pytest.mark.parametrize("counts", [[500], [1, 16, 0, 483], [3000, 17]])
def test_evaluation_uses_the_running_statistics_with_and_without_gradients(counts: list[int]) -> None:
    layer, oracle = layer_and_oracle()
    x = some_points(sum(counts))
    layer(x)
    oracle(x.double())
    layer.eval()
    oracle.eval()
    expected = oracle_max(oracle, x.double(), counts).float()
    torch.testing.assert_close(layer.max_over_points(x, counts), expected, atol=1e-4, rtol=1e-4)
    with torch.no_grad():
        torch.testing.assert_close(layer.max_over_points(x, counts), expected, atol=1e-4, rtol=1e-4)
    statistics = layer.running_mean.clone()
    layer(x + 1.0)
    assert torch.equal(layer.running_mean, statistics)


def test_no_points_at_all_give_zeros_and_leave_the_statistics_alone() -> None:
    layer, _ = layer_and_oracle()
    pooled = layer.max_over_points(torch.zeros(0, IN), [0, 0])
    assert torch.equal(pooled, torch.zeros(2, OUT))
    assert torch.equal(layer.running_mean, torch.zeros(OUT))


def test_one_point_is_finite_in_training() -> None:
    layer, _ = layer_and_oracle()
    pooled = layer.max_over_points(some_points(1), [1])
    torch.testing.assert_close(pooled[0], layer.beta.relu(), atol=2e-3, rtol=0.0)  # its own mean, no spread


def test_bfloat16_keeps_statistics_and_maxima_in_float32() -> None:
    layer, oracle = layer_and_oracle()
    x = some_points(500)
    with torch.autocast("cpu", dtype=torch.bfloat16):
        pooled = layer.max_over_points(x, [500])
    assert pooled.dtype == torch.float32
    torch.testing.assert_close(pooled, oracle_max(oracle, x.double(), [500]).float(), atol=0.05, rtol=0.02)
    torch.testing.assert_close(layer.running_var, oracle[1].running_var.float(), atol=1e-5, rtol=1e-4)


def test_scripted_equals_eager() -> None:
    layer, _ = layer_and_oracle()
    layer.eval()
    x = some_points(100)
    scripted = torch.jit.script(Pooled(layer))
    torch.testing.assert_close(scripted(x, [60, 40]), layer.max_over_points(x, [60, 40]), atol=1e-6, rtol=1e-6)
    with torch.no_grad():
        torch.testing.assert_close(scripted(x, [60, 40]), layer.max_over_points(x, [60, 40]), atol=1e-6, rtol=1e-6)


class Pooled(nn.Module):
    def __init__(self, layer: PointLinear) -> None:
        super().__init__()
        self.layer = layer

    def forward(self, x: Tensor, counts: list[int]) -> Tensor:
        return self.layer.max_over_points(x, counts)
