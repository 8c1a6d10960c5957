"""The trajectory encoder: three poolings, three convolutions, and no step lost between pixels."""

import pytest
import torch
from torch import Tensor, nn

from navtool.train.graspe.trajectory_net import TrajectoryNet

pytestmark = pytest.mark.filterwarnings("ignore:.torch.jit.script. is deprecated:DeprecationWarning")


def swath(first_column: int) -> Tensor:
    image = torch.zeros(1, 1, 240, 320, dtype=torch.uint8)
    image[:, :, 120:, first_column : first_column + 60] = 255
    return image


def net(height: int = 240, width: int = 320) -> TrajectoryNet:
    torch.manual_seed(0)
    return TrajectoryNet(20, height=height, width=width, channels=[8, 16, 32])


@pytest.mark.parametrize(("height", "width"), [(240, 320), (48, 48), (63, 97)])
def test_features_are_in_the_open_unit_interval(height: int, width: int) -> None:
    features = net(height, width)(torch.randint(0, 2, (3, 1, height, width), dtype=torch.uint8) * 255)
    assert features.shape == (3, 20)
    assert bool(((features > 0.0) & (features < 1.0)).all())


def test_has_the_papers_kernels_and_poolings() -> None:
    layers = list(net().modules())
    assert [layer.kernel_size for layer in layers if isinstance(layer, nn.Conv2d)] == [(3, 3), (2, 2), (2, 2)]
    assert sum(isinstance(layer, nn.AvgPool2d) for layer in layers) == 3


def test_a_shift_by_one_pixel_is_seen() -> None:
    encoder = net()
    assert not torch.equal(encoder(swath(100)), encoder(swath(101)))


def test_white_is_one_and_black_is_zero() -> None:
    encoder = net()
    as_unit = encoder.dense(encoder.convolutions(encoder.shrink((swath(100) > 0).float())).flatten(1)).sigmoid()
    torch.testing.assert_close(encoder(swath(100)), as_unit)


def test_scripted_equals_eager() -> None:
    encoder = net()
    torch.testing.assert_close(torch.jit.script(encoder)(swath(90)), encoder(swath(90)), atol=1e-6, rtol=1e-6)
