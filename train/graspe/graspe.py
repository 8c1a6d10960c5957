"""GrASPE: how likely a robot succeeds along a candidate trajectory, given its sensors and their reliability."""

import pickle
from pathlib import Path
from typing import Final

import torch
from torch import Tensor, nn

from navtool.pipeline.feature_graph import feature_graph, reliability_matrix
from navtool.train.errors import TrainError
from navtool.train.graspe.agnn import Agnn
from navtool.train.graspe.config import GraspeConfig
from navtool.train.graspe.image_net import ImageNet
from navtool.train.graspe.point_net import PointNet
from navtool.train.graspe.trajectory_net import TrajectoryNet
from navtool.train.graspe.velocity_net import VelocityNet


class Graspe(nn.Module):
    """Success probabilities of candidate trajectories.

    Reference: GrASPE, section IV and fig. 2.

    Inputs are raw; every normalisation is inside. The graph and the graph network are computed in float32 under
    autocast too: the edges are exponentials, and a bfloat16 exponent would be off by up to 6 %.

    Guarantees:
        Reads no file: `load_pretrained_image_weights` does, once, where a training run begins.
        ``forward`` is `encode_sensors` followed by `score_candidates` with one candidate; K candidates give what K
        calls of ``forward`` give in evaluation mode. All three survive scripting under the same names.
    """

    reliability_aware: Final[bool]

    def __init__(self, config: GraspeConfig) -> None:
        super().__init__()
        graph = config.graph
        self.sizes = graph.sizes()
        self.edge_decay = graph.edge_decay
        self.reliability_aware = config.reliability_aware
        self.pretrained_image_weights = config.pretrained_image_weights
        self.image_net = ImageNet(graph.image, reduction=config.cbam_reduction)
        self.point_net = PointNet(
            graph.point,
            widths=config.point_widths,
            hidden=config.point_hidden,
            transform_widths=config.point_transform_widths,
            transform_hidden=config.point_transform_hidden,
            input_transform=config.point_input_transform,
            feature_transform=config.point_feature_transform,
            range_m=config.point_range_m,
        )
        self.velocity_net = VelocityNet(
            graph.velocity,
            history=config.history,
            channels=config.velocity_channels,
            v_max_mps=config.v_max_mps,
            omega_max_radps=config.omega_max_radps,
        )
        self.trajectory_net = TrajectoryNet(
            graph.trajectory,
            height=config.image_height,
            width=config.image_width,
            channels=config.trajectory_channels,
        )
        self.agnn = Agnn(
            graph.nodes(),
            config.horizon,
            channels=config.graph_channels,
            heads=config.attention_heads,
            edge_attention=config.attention_uses_edges,
            self_loop_weight=config.self_loop_weight,
            dense_hidden=config.dense_hidden,
            dropout=config.dropout,
        )

    def forward(
        self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor, trajectory: Tensor, reliability: Tensor
    ) -> Tensor:
        """Return the probability of success at each step of one trajectory per sample.

        Args:
            image: Camera image, RGB.
            points: LiDAR points in metres in the robot's frame, padded.
            count: Valid points of each cloud.
            velocity: [v_mps, omega_radps], oldest first.
            trajectory: 255 inside the swath of the candidate, 0 outside.
            reliability: [r_img, r_point] in [0, 1].

        Shape:
            image: [B, 3, H, W] uint8; points: [B, P, 3]; count: [B] int; velocity: [B, history, 2];
            trajectory: [B, 1, H, W] uint8; reliability: [B, 2]; result: [B, T] in (0, 1).
        """
        f_sensors = self.encode_sensors(image, points, count, velocity)
        return self.score_candidates(f_sensors, trajectory.unsqueeze(1), reliability).squeeze(1)

    def encode_sensors(self, image: Tensor, points: Tensor, count: Tensor, velocity: Tensor) -> Tensor:
        """Return the image, point and velocity features in (0, 1), which all candidates of a tick share, [B, F]."""
        return torch.cat(
            [self.image_net(image), self.point_net(points, count), self.velocity_net(velocity)], dim=1
        ).float()

    def score_candidates(self, f_sensors: Tensor, trajectory: Tensor, reliability: Tensor) -> Tensor:
        """Return the probability of success at each step of each candidate.

        Shape:
            f_sensors: [B, F] of `encode_sensors`; trajectory: [B, K, 1, H, W] uint8; reliability: [B, 2];
            result: [B, K, T] in (0, 1).
        """
        batch, candidates = trajectory.shape[0], trajectory.shape[1]
        f_trajectory = self.trajectory_net(trajectory.flatten(0, 1)).float()  # [B K, features]
        f_trajectory = f_trajectory.view(batch, candidates, -1)
        f_vec = torch.cat([f_sensors.float().unsqueeze(1).expand(-1, candidates, -1), f_trajectory], dim=2)  # [B, K, N]
        r = reliability.float() if self.reliability_aware else torch.ones_like(reliability, dtype=torch.float32)
        with torch.autocast(device_type="cpu", enabled=False), torch.autocast(device_type="cuda", enabled=False):
            r_pairs = reliability_matrix(r[:, 0], r[:, 1], self.sizes)  # [B, N, N]
            weights = feature_graph(f_vec, r_pairs.unsqueeze(1), self.edge_decay)  # [B, K, N, N]
            scores: Tensor = self.agnn(f_vec.flatten(0, 1), weights.flatten(0, 1))  # [B K, T]
        return scores.view(batch, candidates, -1)

    def load_pretrained_image_weights(self) -> None:
        """Start the camera encoder from the configured file; do nothing where none is configured.

        Raises:
            TrainError: The file is missing, is not a plain state dict, or holds another network.
        """
        if self.pretrained_image_weights is None:
            return
        path = Path(self.pretrained_image_weights)
        cure = "save the state_dict() of torchvision's resnet18 there (nothing is downloaded), or leave the option null"
        if not path.is_file():
            raise TrainError("no such file of pretrained image weights", where=path, cure=cure)
        try:
            self.image_net.load_backbone(torch.load(path, map_location="cpu", weights_only=True))
        except (pickle.UnpicklingError, RuntimeError, AttributeError, EOFError, OSError) as error:
            first = (str(error).strip() or "the file is empty").splitlines()[0]
            raise TrainError(f"not a ResNet18 state dict: {first}", where=path, cure=cure) from error
