"""The LiDAR encoder: PointNet over the valid points of each cloud."""

from itertools import pairwise
from typing import Final

import torch
from torch import Tensor, nn

from navtool.train.layers.point_linear import PointLinear


class TransformNet(nn.Module):
    """A square matrix for each cloud, the identity before training, that brings it into a common pose.

    Reference: Qi et al., PointNet, 2017, section 4.2 (T-Net).

    Shape:
        x: [M, channels], the points of all clouds one after another, counts[b] of them from cloud b;
        result: [B, channels, channels].
    """

    def __init__(self, channels: int, widths: list[int], hidden: list[int]) -> None:
        super().__init__()
        self.channels = channels
        self.encoder = PointEncoder(channels, widths)
        self.head = dense_head(widths[-1], hidden, channels * channels)
        for parameter in self.head[len(self.head) - 1].parameters():
            nn.init.zeros_(parameter)

    def forward(self, x: Tensor, counts: list[int]) -> Tensor:
        """Return the matrices."""
        matrix: Tensor = self.head(self.encoder(x, counts))
        return matrix.view(-1, self.channels, self.channels) + torch.eye(self.channels, device=x.device)


class PointEncoder(nn.Module):
    """Shared layers and the maximum over the points of each cloud; a cloud without points gives zeros.

    Shape:
        x: [M, channels], counts[b] rows from cloud b; result: [B, widths[-1]].
    """

    def __init__(self, channels: int, widths: list[int]) -> None:
        super().__init__()
        *shared, last = pairwise([channels, *widths])
        self.shared = nn.ModuleList(PointLinear(before, after) for before, after in shared)
        self.last = PointLinear(*last)

    def forward(self, x: Tensor, counts: list[int]) -> Tensor:
        """Return one vector for each cloud."""
        for layer in self.shared:
            x = layer(x)
        return self.last.max_over_points(x, counts)


class PointNet(nn.Module):
    """Point cloud features in (0, 1).

    Reference: GrASPE, section IV-B.2; Qi et al., PointNet, 2017.

    Guarantees:
        The order of the points does not matter, nor does what stands in the padding, in training and evaluation
        alike: statistics and maximum are taken over the valid points only. An empty cloud has defined, finite features.

    Args:
        features: Size of the feature vector.
        widths: Channels of the shared layers.
        hidden: Units of the dense layers after the maximum. They carry no batch norm: a batch of one trains.
        transform_widths: Channels of the shared layers of the transform networks.
        transform_hidden: Units of their dense layers.
        input_transform: Whether clouds are turned first.
        feature_transform: Whether features are mapped after the second shared layer.
        range_m: Coordinate that is scaled to 1.

    Shape:
        points: [B, P, 3] metres in the robot's frame; count: [B] int, how many of the P are valid, in [0, P];
        result: [B, features].
    """

    input_transform: Final[bool]
    feature_transform: Final[bool]

    def __init__(
        self,
        features: int,
        *,
        widths: list[int],
        hidden: list[int],
        transform_widths: list[int],
        transform_hidden: list[int],
        input_transform: bool = True,
        feature_transform: bool = False,
        range_m: float = 20.0,
    ) -> None:
        super().__init__()
        self.range_m = range_m
        self.input_transform = input_transform
        self.feature_transform = feature_transform
        if input_transform:
            self.turn_input = TransformNet(3, transform_widths, transform_hidden)
        before = widths[:2] if feature_transform else []
        self.before = nn.ModuleList(PointLinear(a, b) for a, b in pairwise([3, *before]))
        if feature_transform:
            self.turn_features = TransformNet(before[-1], transform_widths, transform_hidden)
        self.encoder = PointEncoder(before[-1] if before else 3, widths[len(before) :])
        self.head = dense_head(widths[-1], hidden, features)

    def forward(self, points: Tensor, count: Tensor) -> Tensor:
        """Return the feature vectors."""
        valid = torch.arange(points.shape[1], device=points.device) < count.unsqueeze(1)  # [B, P]
        counts: list[int] = valid.sum(dim=1).tolist()
        x = points[valid] / self.range_m  # [M, 3]
        if self.input_transform:
            x = apply_per_cloud(x, counts, self.turn_input(x, counts))
        for layer in self.before:
            x = layer(x)
        if self.feature_transform:
            x = apply_per_cloud(x, counts, self.turn_features(x, counts))
        features: Tensor = self.head(self.encoder(x, counts)).sigmoid()
        return features


def apply_per_cloud(x: Tensor, counts: list[int], matrices: Tensor) -> Tensor:
    """Return the points of each cloud times its own matrix, [M, channels]."""
    return torch.cat([part @ matrices[cloud] for cloud, part in enumerate(torch.split(x, counts))])


def dense_head(channels: int, hidden: list[int], out: int) -> nn.Sequential:
    """Return dense layers with ReLU between them."""
    layers: list[nn.Module] = []
    for width in hidden:
        layers += [nn.Linear(channels, width), nn.ReLU()]
        channels = width
    return nn.Sequential(*layers, nn.Linear(channels, out))
