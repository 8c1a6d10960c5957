"""GrASPE as an artefact holds it."""

from torch import Tensor, nn

from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.graspe import Graspe
from navtool.train.layers.checked_input import check_input


class OnboardGraspe(nn.Module):
    """A network that refuses inputs of another type or shape, with a message, instead of computing nonsense."""

    def __init__(self, model: Graspe, config: GraspeConfig) -> None:
        super().__init__()
        self.model = model
        self.height = config.image_height
        self.width = config.image_width
        self.history = config.history

    def forward(
        self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor, trajectory: Tensor, reliability: Tensor
    ) -> Tensor:
        """Return the probability of success at each step of one trajectory per sample, [B, T]."""
        check_input(trajectory, "trajectory", "uint8", [-1, 1, self.height, self.width])
        features = self.encode_sensors(image, points, count, velocity)
        return self.score_candidates(features, trajectory.unsqueeze(1), reliability).squeeze(1)

    def encode_sensors(self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor) -> Tensor:
        """Return what all candidates of a tick share, [B, F]."""
        check_input(image, "image", "uint8", [-1, 3, self.height, self.width])
        batch = image.shape[0]
        if batch < 1:
            raise ValueError("image must hold at least one sample")
        check_input(points, "points", "float32", [batch, -1, 3])
        check_input(count, "count", "int64", [batch])
        if int(count.min()) < 0 or int(count.max()) > points.shape[1]:
            raise ValueError("count must lie between 0 and the number of points")
        check_input(velocity, "velocity", "float32", [batch, self.history, 2])
        return self.model.encode_sensors(image, points, count, velocity)

    def score_candidates(self, features: Tensor, trajectory: Tensor, reliability: Tensor) -> Tensor:
        """Return the probability of success at each step of each candidate, [B, K, T]."""
        batch = features.shape[0]
        check_input(trajectory, "trajectory", "uint8", [batch, -1, 1, self.height, self.width])
        check_input(reliability, "reliability", "float32", [batch, 2])
        return self.model.score_candidates(features, trajectory, reliability)
