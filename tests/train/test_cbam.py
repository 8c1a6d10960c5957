"""Block attention: shapes, ranges, and the equations against a naive reading."""

import pytest
import torch
from torch import Tensor
from torch.nn import functional

from navtool.train.layers.cbam import Cbam


def feature_map() -> Tensor:
    return torch.randn(2, 32, 6, 9, generator=torch.Generator().manual_seed(0))


def test_attentions_are_open_unit_weights_of_their_shape() -> None:
    torch.manual_seed(0)
    layer, x = Cbam(32), feature_map()
    channel, spatial = layer.channel_attention(x), layer.spatial_attention(x)
    assert channel.shape == (2, 32, 1, 1)
    assert spatial.shape == (2, 1, 6, 9)
    for attention in (channel, spatial):
        assert attention.min().item() > 0.0
        assert attention.max().item() < 1.0


def test_output_is_smaller_than_the_input_everywhere_and_has_its_signs() -> None:
    torch.manual_seed(0)
    layer, x = Cbam(32), feature_map()
    y = layer(x)
    assert y.shape == x.shape
    assert bool((y.abs() < x.abs()).all())
    assert torch.equal(y.sign(), x.sign())


def test_equals_the_equations_read_naively() -> None:
    torch.manual_seed(0)
    layer, x = Cbam(32, reduction=8, kernel_size=3), feature_map()
    result = layer(x)
    for sample in range(2):
        maps = x[sample]
        means = torch.stack([one.mean() for one in maps])
        peaks = torch.stack([one.max() for one in maps])
        weighed = maps * torch.sigmoid(layer.channel_mlp(means) + layer.channel_mlp(peaks)).view(-1, 1, 1)
        pooled = functional.pad(torch.stack([weighed.mean(dim=0), weighed.max(dim=0).values]), (1, 1, 1, 1))
        kernel = layer.spatial.weight[0]
        for row in range(6):
            for column in range(9):
                score = (pooled[:, row : row + 3, column : column + 3] * kernel).sum()
                expected = weighed[:, row, column] * torch.sigmoid(score)
                torch.testing.assert_close(result[sample, :, row, column], expected, atol=1e-5, rtol=1e-5)


@pytest.mark.parametrize(("channels", "reduction", "hidden"), [(64, 16, 4), (8, 16, 1), (32, 1, 32)])
def test_reduction_sets_the_hidden_units(channels: int, reduction: int, hidden: int) -> None:
    assert Cbam(channels, reduction=reduction).channel_mlp[0].out_features == hidden
