"""The velocity encoder sees the whole history, scaled, and nothing else."""

import pytest
import torch

from navtool.train.graspe.velocity_net import VelocityNet

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")


@pytest.mark.parametrize("history", [20, 50])
def test_features_are_in_the_open_unit_interval_and_every_step_has_a_say(history: int) -> None:
    torch.manual_seed(0)
    net = VelocityNet(20, history=history)
    velocity = torch.randn(4, history, 2, requires_grad=True)
    features = net(velocity)
    assert features.shape == (4, 20)
    assert bool(((features > 0.0) & (features < 1.0)).all())
    (gradient,) = torch.autograd.grad(features.sum(), velocity)
    assert bool((gradient.abs().sum(dim=0) > 0.0).all())


def test_scales_are_units_only() -> None:
    torch.manual_seed(0)
    net = VelocityNet(history=20, v_max_mps=1.0, omega_max_radps=1.0)
    twice = VelocityNet(history=20, v_max_mps=2.0, omega_max_radps=4.0)
    twice.load_state_dict({**net.state_dict(), "scale": twice.scale})
    velocity = torch.randn(4, 20, 2)
    torch.testing.assert_close(twice(velocity * torch.tensor([2.0, 4.0])), net(velocity))


def test_has_the_papers_four_dilations() -> None:
    layers = [layer for layer in VelocityNet().convolutions if isinstance(layer, torch.nn.Conv1d)]
    assert [layer.dilation for layer in layers] == [(3,), (2,), (2,), (2,)]


def test_scripted_equals_eager() -> None:
    torch.manual_seed(0)
    net, velocity = VelocityNet(), torch.randn(4, 50, 2)
    torch.testing.assert_close(torch.jit.script(net)(velocity), net(velocity), atol=1e-6, rtol=1e-6)
