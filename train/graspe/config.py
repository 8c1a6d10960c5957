"""The sizes and choices of the GrASPE network."""

import math
from dataclasses import dataclass, field
from pathlib import Path

from navtool.base.setting_checks import fault, outside
from navtool.base.setting_error import Fault, refuse
from navtool.pipeline.feature_graph import FeatureGraphConfig
from navtool.train.model_config import ModelConfig
from navtool.train.success.windows import DataConfig


@dataclass(kw_only=True, slots=True)
class GraspeConfig(ModelConfig):
    """The network of GrASPE, section IV; defaults are the paper's where it names them."""

    graph: FeatureGraphConfig = field(default_factory=FeatureGraphConfig)
    """Nodes per encoder and the decay of the edges, eq. (6)."""
    horizon: int = 10
    """Predicted steps T, at least 1."""
    history: int = 50
    """Steps of the velocity history, at least 20: below that the dilated convolutions skip some."""
    image_height: int = 240
    """Height of the camera and the trajectory image, px, at least 48."""
    image_width: int = 320
    """Width of the camera and the trajectory image, px, at least 48."""
    v_max_mps: float = 2.0
    """Linear velocity that is scaled to 1, above 0."""
    omega_max_radps: float = 2.0
    """Angular velocity that is scaled to 1, above 0."""
    point_range_m: float = 20.0
    """Coordinate that is scaled to 1, above 0."""
    cbam_reduction: int = 16
    """The channel attention's hidden layer has channels / this many units, at least 1."""
    pretrained_image_weights: str | None = None
    """File with a torchvision ResNet18 state dict; None starts from random weights. Nothing is ever downloaded."""
    point_widths: list[int] = field(default_factory=lambda: [64, 64, 64, 128, 1024])
    """Channels of PointNet's shared layers, at least 2 of them."""
    point_hidden: list[int] = field(default_factory=lambda: [512, 256])
    """Units of the dense layers between PointNet's maximum and its features."""
    point_transform_widths: list[int] = field(default_factory=lambda: [64, 128, 256])
    """Channels of the shared layers of PointNet's transform networks; PointNet has 1,024 at the end, at 4x the cost."""
    point_transform_hidden: list[int] = field(default_factory=lambda: [128, 64])
    """Units of the dense layers of PointNet's transform networks."""
    point_input_transform: bool = True
    """Whether a transform network turns the cloud before the shared layers see it."""
    point_feature_transform: bool = False
    """Whether a second one maps the features after the second shared layer (costs much, gains little)."""
    velocity_channels: int = 16
    """Channels of each of the velocity encoder's four convolutions, at least 1."""
    trajectory_channels: list[int] = field(default_factory=lambda: [8, 16, 32])
    """Channels of the trajectory encoder's three convolutions."""
    graph_channels: int = 16
    """Channels of each graph layer (and attention head), at least 1; the paper has 16."""
    attention_heads: int = 1
    """Heads of the graph attention layer, at least 1."""
    attention_uses_edges: bool = True
    """Whether the edge weights enter the attention; if not, only the two graph convolutions see them."""
    self_loop_weight: float | None = None
    """Edge feature of a node's loop to itself in the attention, in [0, 1]; None takes the mean of its other edges."""
    dense_hidden: int = 128
    """Units between the two dense layers, at least 1."""
    dropout: float = 0.5
    """Dropout after the graph attention, in [0, 1)."""
    reliability_aware: bool = True
    """Whether reliability shapes the graph; if not (the paper's ablation), r = 1 for every pair."""

    def __post_init__(self) -> None:
        """Name every fault of the configuration in one error."""
        sizes = ("horizon", "cbam_reduction", "velocity_channels", "graph_channels", "attention_heads", "dense_hidden")
        refuse(
            outside(self, 1, math.inf, *sizes),
            outside(self, 20, math.inf, "history"),
            outside(self, 48, math.inf, "image_height", "image_width", unit="px"),
            outside(self, 0, math.inf, "v_max_mps", "omega_max_radps", "point_range_m", above=True),
            self._too_few("point_widths", 3 if self.point_feature_transform else 2),
            self._too_few("point_hidden", 0),
            self._too_few("point_transform_widths", 1),
            self._too_few("point_transform_hidden", 0),
            self._too_few("trajectory_channels", 3),
            fault(
                "trajectory_channels",
                f"{self.trajectory_channels} are more than 3 numbers, one a convolution",
                when=len(self.trajectory_channels) > 3,
            ),
            outside(self, 0, 1, "dropout", below=True),
            outside(self, 0, 1, "self_loop_weight", cure="null takes the mean"),
        )

    def _too_few(self, name: str, least: int) -> list[Fault]:
        widths: list[int] = getattr(self, name)
        wrong = len(widths) < least or any(width < 1 for width in widths)
        return fault(name, f"{widths} are not {least} numbers or more, each 1 or more", when=wrong)

    def faults(self, data: DataConfig) -> list[Fault]:
        """Where the network's horizon or history is not that of the samples."""
        return [
            Fault(f"model.{ours}", f"{mine} differs from data.{theirs} = {other}", "set both")
            for ours, mine, theirs, other in (
                ("horizon", self.horizon, "horizon_steps", data.horizon_steps),
                ("history", self.history, "history_steps", data.history_steps),
            )
            if mine != other
        ]

    def files(self) -> tuple[Path, ...]:
        """The pretrained weights, where there are any."""
        return () if self.pretrained_image_weights is None else (Path(self.pretrained_image_weights),)
