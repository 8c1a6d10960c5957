"""The trajectory encoder: a small convolutional network over the trajectory image."""

from torch import Tensor, nn

from navtool.train.layers.first_weights import spread_relu, spread_sigmoid

KERNELS = (3, 2, 2)
POOLS = (4, 2, 2)


class TrajectoryNet(nn.Module):
    """Trajectory features in (0, 1) from the swath that the robot would drive over.

    Reference: GrASPE, section IV-B.4 (three pooling and three convolutional layers, kernels 3, 2, 2).

    Args:
        features: Size of the feature vector.
        height: Of the image, px.
        width: Of the image, px.
        channels: Of the three convolutions.

    Shape:
        trajectory: [B, 1, height, width] uint8, 255 inside the swath, 0 outside; result: [B, features].

    Note:
        The paper leaves order and size of the pooling open. Each pooling comes before its convolution and takes means,
        over 4, 2 and 2 px: the first keeps a shift of the swath by less than 4 px as a grey value, and a planner's
        50 candidates cost 1/16 of what convolutions on the full image would.
    """

    def __init__(self, features: int = 20, *, height: int = 240, width: int = 320, channels: list[int]) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        before = 1
        for pool, kernel, after in zip(POOLS, KERNELS, channels, strict=True):
            layers += [nn.AvgPool2d(pool), nn.Conv2d(before, after, kernel), nn.ReLU()]
            height, width = height // pool - kernel + 1, width // pool - kernel + 1
            before = after
        self.shrink = layers[0]
        self.convolutions = nn.Sequential(*layers[1:])
        self.dense = nn.Linear(before * height * width, features)
        spread_relu(self.convolutions)
        spread_sigmoid(self.dense)

    def forward(self, trajectory: Tensor) -> Tensor:
        """Return the feature vectors."""
        x = self.shrink(trajectory.to(self.dense.weight.dtype)) / 255.0  # scaled where it has become small
        features: Tensor = self.dense(self.convolutions(x).flatten(1)).sigmoid()
        return features
