"""PointNet: neither the order of the points nor the padding matters, and an empty cloud is defined."""

from typing import Any

import pytest
import torch
from torch import Tensor

from navtool.train.graspe.point_net import PointNet

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")

COUNT = torch.tensor([50, 0, 17, 1])


def small_net(**options: Any) -> PointNet:
    torch.manual_seed(0)
    sizes: dict[str, Any] = {"widths": [8, 8, 16], "hidden": [8], "transform_widths": [8, 16], "transform_hidden": [8]}
    return PointNet(5, **sizes, **options)


def some_clouds() -> Tensor:
    points = torch.randn(4, 50, 3, generator=torch.Generator().manual_seed(1)) * 5.0
    return points * (torch.arange(50).view(1, 50, 1) < COUNT.view(4, 1, 1))


VARIANTS: list[dict[str, Any]] = [
    {},
    {"input_transform": False},
    {"feature_transform": True},
    {"input_transform": False, "feature_transform": True},
]


@pytest.mark.parametrize("options", VARIANTS)
def test_features_are_finite_in_the_open_unit_interval(options: dict[str, Any]) -> None:
    features = small_net(**options)(some_clouds(), COUNT)
    assert features.shape == (4, 5)
    assert bool(((features > 0.0) & (features < 1.0)).all())


@pytest.mark.parametrize("training", [True, False])
def test_order_does_not_matter(*, training: bool) -> None:
    net = small_net(feature_transform=True).train(training)
    points, generator = some_clouds(), torch.Generator().manual_seed(2)
    shuffled = points.clone()
    for cloud, count in enumerate(COUNT.tolist()):
        shuffled[cloud, :count] = points[cloud, torch.randperm(count, generator=generator)]
    torch.testing.assert_close(net(shuffled, COUNT), net(points, COUNT), atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize("training", [True, False])
def test_padding_does_not_matter_however_long_or_filled(*, training: bool) -> None:
    net = small_net(feature_transform=True).train(training)
    points = some_clouds()
    expected = net(points, COUNT)
    longer = torch.cat([points, torch.zeros(4, 30, 3)], dim=1)
    assert torch.equal(net(longer, COUNT), expected)
    rubbish = longer.clone()
    for cloud, count in enumerate(COUNT.tolist()):
        rubbish[cloud, count:] = 1e6
    assert torch.equal(net(rubbish, COUNT), expected)


def test_padding_does_not_reach_the_running_statistics() -> None:
    short, padded = small_net(), small_net()
    points = some_clouds()
    short(points, COUNT)
    padded(torch.cat([points, torch.zeros(4, 500, 3)], dim=1), COUNT)
    for name, tensor in short.state_dict().items():
        assert torch.equal(padded.state_dict()[name], tensor), name


def test_an_empty_cloud_has_the_same_features_alone_and_among_others() -> None:
    net = small_net().eval()
    among = net(some_clouds(), COUNT)[1]
    alone = net(torch.zeros(1, 50, 3), torch.tensor([0]))[0]
    torch.testing.assert_close(among, alone)
    trained = small_net().train()(torch.zeros(2, 50, 3), torch.tensor([0, 0]))
    assert bool(torch.isfinite(trained).all())


def test_transforms_start_as_the_identity() -> None:
    net = small_net(feature_transform=True).eval()
    plain = small_net(input_transform=False, feature_transform=False).eval()
    layers = [*net.before, *net.encoder.shared, net.encoder.last]
    for target, source in zip([*plain.encoder.shared, plain.encoder.last], layers, strict=True):
        target.load_state_dict(source.state_dict())
    plain.head.load_state_dict(net.head.state_dict())
    torch.testing.assert_close(net(some_clouds(), COUNT), plain(some_clouds(), COUNT), atol=1e-6, rtol=1e-5)


def test_every_parameter_has_a_gradient_in_a_batch_of_one() -> None:
    net = small_net(feature_transform=True)
    for transform in (net.turn_input, net.turn_features):
        torch.nn.init.normal_(next(transform.head[-1].parameters()))  # behind zeros nothing would have one
    torch.autograd.backward(net(some_clouds()[:1], COUNT[:1]).sum())
    silent = [name for name, parameter in net.named_parameters() if parameter.grad is None]
    assert silent == []
    reached = [name for name, p in net.named_parameters() if p.grad is not None and float(p.grad.abs().sum()) > 0.0]
    assert {name.split(".")[0] for name in reached} == {"turn_input", "before", "turn_features", "encoder", "head"}


@pytest.mark.parametrize("options", VARIANTS)
def test_scripted_equals_eager(options: dict[str, Any]) -> None:
    net = small_net(**options).eval()
    scripted = torch.jit.script(net)
    torch.testing.assert_close(scripted(some_clouds(), COUNT), net(some_clouds(), COUNT), atol=1e-6, rtol=1e-5)
