"""The velocity encoder: dilated convolutions over the velocity history."""

import torch
from torch import Tensor, nn

from navtool.train.layers.first_weights import spread_relu, spread_sigmoid

KERNEL = 3
DILATIONS = (3, 2, 2, 2)


class VelocityNet(nn.Module):
    """Velocity features in (0, 1) from the newest steps of linear and angular velocity.

    Reference: GrASPE, section IV-B.3 (four convolutions with dilation 3, 2, 2, 2).

    Args:
        features: Size of the feature vector.
        history: Steps of the history, at least 20 (the four convolutions span 19, with two gaps).
        channels: Of each convolution.
        v_max_mps: Linear velocity that is scaled to 1.
        omega_max_radps: Angular velocity that is scaled to 1.

    Shape:
        velocity: [B, history, 2] of [v_mps, omega_radps], oldest first; result: [B, features].

    Note:
        The paper reshapes the history to 100 values and names neither kernel nor channels. Here v and omega are two
        channels over time (a window over the interleaved values would mix units), kernel 3, ReLU between the
        convolutions, no padding: every output has seen measured steps only; a dense layer brings them to the features.
    """

    scale: Tensor

    def __init__(
        self,
        features: int = 20,
        *,
        history: int = 50,
        channels: int = 16,
        v_max_mps: float = 2.0,
        omega_max_radps: float = 2.0,
    ) -> None:
        super().__init__()
        self.register_buffer("scale", torch.tensor([1.0 / v_max_mps, 1.0 / omega_max_radps]))
        layers: list[nn.Module] = []
        before = 2
        for dilation in DILATIONS:
            layers += [nn.Conv1d(before, channels, KERNEL, dilation=dilation), nn.ReLU()]
            before = channels
        self.convolutions = nn.Sequential(*layers)
        steps = history - (KERNEL - 1) * sum(DILATIONS)
        self.dense = nn.Linear(channels * steps, features)
        spread_relu(self.convolutions)
        spread_sigmoid(self.dense)

    def forward(self, velocity: Tensor) -> Tensor:
        """Return the feature vectors."""
        x = (velocity * self.scale).transpose(1, 2)  # [B, 2, history]
        features: Tensor = self.dense(self.convolutions(x).flatten(1)).sigmoid()
        return features
