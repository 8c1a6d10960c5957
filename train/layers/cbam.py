"""Convolutional block attention: which channels and which places of a feature map matter."""

import torch
from torch import Tensor, nn


class Cbam(nn.Module):
    r"""Weigh a feature map by channel attention, then by spatial attention.

    .. math::
        F' = \sigma(\mathrm{MLP}(\mathrm{avg}_{hw} F) + \mathrm{MLP}(\max_{hw} F)) \odot F, \qquad
        F'' = \sigma(f^{7 \times 7}([\mathrm{avg}_c F'; \max_c F'])) \odot F'

    Reference: Woo et al., CBAM, 2018, eq. (1) to (3).

    Guarantees:
        Both attentions lie in (0, 1): no element of the output is larger in magnitude than in the input.

    Args:
        channels: Channels of the feature map.
        reduction: The hidden layer of the channel MLP has channels / reduction units, at least 1.
        kernel_size: Odd window of the spatial attention, px.

    Shape:
        x: [B, channels, H, W]; result: the same.
    """

    def __init__(self, channels: int, *, reduction: int = 16, kernel_size: int = 7) -> None:
        super().__init__()
        hidden = max(channels // reduction, 1)
        self.channel_mlp = nn.Sequential(nn.Linear(channels, hidden), nn.ReLU(), nn.Linear(hidden, channels))
        self.spatial = nn.Conv2d(2, 1, kernel_size, padding=kernel_size // 2, bias=False)

    def forward(self, x: Tensor) -> Tensor:
        """Return the weighed feature map."""
        x = x * self.channel_attention(x)
        return x * self.spatial_attention(x)

    def channel_attention(self, x: Tensor) -> Tensor:
        """Return the weight of each channel in (0, 1), [B, channels, 1, 1]."""
        score: Tensor = self.channel_mlp(x.mean(dim=(2, 3))) + self.channel_mlp(x.amax(dim=(2, 3)))  # [B, C]
        return score.sigmoid().unsqueeze(2).unsqueeze(3)

    def spatial_attention(self, x: Tensor) -> Tensor:
        """Return the weight of each place in (0, 1), [B, 1, H, W]."""
        pooled = torch.cat([x.mean(dim=1, keepdim=True), x.amax(dim=1, keepdim=True)], dim=1)  # [B, 2, H, W]
        weight: Tensor = self.spatial(pooled).sigmoid()
        return weight
